"""`qzs-rig figures`: files, and what is refused before anything is computed."""

from __future__ import annotations

import json

import pytest

from qzs_rig.cli.main import execute


def test_figure_23_is_a_page_and_pictures(tmp_path, capsys):
    assert execute(('figures', '23', '--out', str(tmp_path), '--json')) == 0
    (figure,) = json.loads(capsys.readouterr().out)['figures']
    assert figure['number'] == '23'
    names = {'figure_23.html', 'figure_23.svg', 'figure_23.png'}
    assert {path.name for path in tmp_path.iterdir()} == names
    page = (tmp_path / 'figure_23.html').read_text(encoding='utf-8')
    assert 'harmonic balance' in page and 'jump down' in page


@pytest.mark.parametrize(
    ('number', 'message'),
    [('21', 'figure 21 is unknown; known: 19, 20, 22, 23'), ('23', 'figure_23.html')],
)
def test_what_is_refused(tmp_path, capsys, number, message):
    (tmp_path / 'figure_23.html').touch()
    assert execute(('figures', number, '--out', str(tmp_path))) == 2
    assert message in capsys.readouterr().err
