"""The still picture."""

from __future__ import annotations

import sys
from dataclasses import replace

import pytest

from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.report.run_page import write_picture


@pytest.mark.parametrize(('suffix', 'start'), [('.svg', b'<?xml'), ('.png', b'\x89PNG')])
def test_same_input_same_bytes(run, theory, tmp_path, suffix, start):
    for name in ('one', 'two'):
        write_picture(tmp_path / (name + suffix), [('run', run)], theory=[theory], title='sweep')
    one, two = ((tmp_path / (name + suffix)).read_bytes() for name in ('one', 'two'))
    assert one == two
    assert one.startswith(start)


def test_labels_are_no_mathematics(run, tmp_path):
    odd = Estimate(tuple(replace(c, dof='a$b^{c$') for c in run.curves))
    write_picture(tmp_path / 'odd.svg', [('$x^{$', odd), ('_y', run)], title='$z^{$')


def test_refuses_other_formats(run, tmp_path):
    with pytest.raises(InputError, match=r'p\.pdf is no picture; end its name in .svg or .png'):
        write_picture(tmp_path / 'p.pdf', [('run', run)])


def test_refuses_to_overwrite(run, tmp_path):
    (tmp_path / 'p.svg').write_text('mine')
    with pytest.raises(InputError, match=r'p\.svg is already there; .* --out'):
        write_picture(tmp_path / 'p.svg', [('run', run)])


def test_refuses_to_draw_nothing(tmp_path):
    with pytest.raises(InputError, match='no curve'):
        write_picture(tmp_path / 'p.svg', [('run', Estimate())])


def test_missing_matplotlib_is_named(run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    with pytest.raises(InputError, match='pip install matplotlib'):
        write_picture(tmp_path / 'p.svg', [('run', run)])
