"""`qzs-rig statics` and `qzs-rig springs`: the JSON contract, files, refusals."""

from __future__ import annotations

import csv
import json
import math
import sys

import pytest

from qzs_rig.cli.main import execute
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN, Design
from qzs_rig.units import DOFS

PAGES = ('svg', 'png')
WEIGHTED = ('closed_form', 'corrected', 'taylor', 'printed', 'geometric')


@pytest.fixture
def told(capsys):
    """Runs a command; its exit code, standard output and standard error."""

    def run(*words):
        code = execute(words)
        said = capsys.readouterr()
        return code, said.out, said.err

    return run


@pytest.mark.parametrize('law', RESTORING)
@pytest.mark.parametrize('dof', DOFS)
def test_json_contract(told, law, dof):
    code, out, err = told(*('statics', '--law', law, '--dof', dof, '--at', '-0.1,0,0.25', '--json'))
    document = json.loads(out)
    x = [-0.1, 0.0, 0.25]
    number = DOFS.index(dof)
    formula = RESTORING[law].along(number, math.sqrt)
    weight = PAPER_DESIGN.b if law in WEIGHTED and dof == 'vertical' else 0.0
    assert (code, err) == (0, '')
    assert {k: document[k] for k in ('law', 'dof', 'units', 'x')} == {
        'law': law,
        'dof': dof,
        'units': 'nondimensional',
        'x': x,
    }
    expected = [formula(PAPER_DESIGN, value) + weight for value in x]
    assert document['force'] == pytest.approx(expected, abs=1e-12)
    slopes = [RESTORING[law].stiffness_along(number)(PAPER_DESIGN, value) for value in x]
    assert document['stiffness'] == pytest.approx(slopes, abs=1e-12)
    assert document.get('static_load') == (pytest.approx(weight, abs=1e-12) if weight else None)


def test_set_overrides_the_design(told):
    sets = {'A': 1.5, 'k3_hat': 0.5, 'L1_hat': 0.8, 'L0_hat': 0.3}
    words = [w for name, value in sets.items() for w in ('--set', f'platform.{name}={value}')]
    design = Design.of(*sets.values())
    for dof in DOFS:
        _, out, _ = told(
            'statics', '--law', 'closed_form', '--dof', dof, '--at=0.3', *words, '--json'
        )
        formula = RESTORING['closed_form'].along(DOFS.index(dof), math.sqrt)
        weight = design.b if dof == 'vertical' else 0.0
        assert json.loads(out)['force'] == pytest.approx([formula(design, 0.3) + weight], abs=1e-12)


def test_points_as_a_table(told):
    code, out, _ = told('statics', '--dof', 'vertical', '--at', '-0.1,0.2')
    assert code == 0
    assert out.splitlines()[0] == 'corrected, vertical'
    assert len(out.splitlines()) == 5


def test_the_summary_says_what_the_library_says(told):
    code, out, _ = told('statics', '--law', 'closed_form', '--json')
    document = json.loads(out)
    assert code == 0
    assert abs(document['conditions']['vertical']) < 1e-14
    assert document['load_capacity']['kg'] == pytest.approx(61.18, abs=5e-3)
    assert set(document['dofs']) == set(DOFS)
    assert document['dofs']['vertical']['stiffness'] == pytest.approx(0.0, abs=1e-14)
    _, text, _ = told('statics', '--dof', 'vertical')
    assert 'QZS conditions' in text
    assert 'vertical rotation  ' not in text.split('Stiffness of law')[1]


@pytest.fixture(scope='module')
def written(tmp_path_factory):
    """The folder of `statics --out`."""
    folder = tmp_path_factory.mktemp('statics') / 'one'
    assert execute(('statics', '--out', str(folder))) == 0
    return folder


def test_files(told, written, tmp_path):
    code, out, _ = told('statics', '--out', str(tmp_path / 'two'), '--json')
    assert code == 0
    names = {path.name for path in written.iterdir()}
    figures = {f'figure_{n}.{kind}' for n in (9, 10, 11, 12) for kind in PAGES}
    assert names == {'statics.html', 'statics.csv', *figures}
    assert {p.rsplit('/', 1)[-1] for p in json.loads(out)['files']} == names
    with (written / 'statics.csv').open(newline='') as file:
        rows = list(csv.DictReader(file))
    law = RESTORING['corrected']
    for row in rows[::97]:
        number, x = DOFS.index(row['dof']), float(row['x'])
        weight = PAPER_DESIGN.b if number == 0 else 0.0
        force = law.along(number, math.sqrt)(PAPER_DESIGN, x) + weight
        assert float(row['force']) == pytest.approx(force, abs=1e-12)
    for name in names:
        assert (written / name).read_bytes() == (tmp_path / 'two' / name).read_bytes()


def test_the_page_needs_nothing_but_itself(written):
    page = (written / 'statics.html').read_text()
    assert "default-src 'none'" in page
    assert page.count('class="plot"') == 8 + 4 + 2 + 2
    assert 'QZS conditions' in page


def test_nothing_is_overwritten(told, written):
    code, _, err = told('statics', '--out', str(written))
    assert code == 2
    assert 'nothing is overwritten' in err


def test_without_matplotlib_page_and_curves_are_written(told, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    code, _, err = told('statics', '--out', str(tmp_path))
    assert code == 0
    assert "pip install 'qzs_rig[picture]'" in err
    assert {path.name for path in tmp_path.iterdir()} == {'statics.html', 'statics.csv'}


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (('--law', 'newton'), "unknown law 'newton'; known: corrected"),
        (('--dof', 'up'), "unknown degree of freedom 'up'; known: vertical"),
        (('--at', '0.1'), '--at needs --dof'),
        (('--dof', 'vertical', '--at', '0.1,a'), "'a' is not a number"),
        (('--dof', 'vertical', '--at', ''), "'' is not a number"),
        (('--dof', 'vertical', '--at', 'nan'), "'nan' is not finite"),
        (('--dof', 'vertical', '--at', '0', '--out', 'x'), 'leave out --out'),
        (('--dof', 'horizontal_rotation', '--at', '-1'), 'outside the domain of corrected'),
        (('--tolerance', '0'), '--tolerance 0 must be above 0'),
        (('--set', 'platform.L1_hat=1.2'), 'platform.L1_hat'),
        (('--set', 'platform.A=1', '--set', 'platform.A=2'), 'is given twice'),
        (('--set', 'platform.B=1'), "unknown parameter 'platform.B'"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(told, words, said):
    code, out, err = told('statics', *words)
    assert (code, out) == (2, '')
    assert said in err
    assert len(err.splitlines()) == 1


def test_springs_of_the_paper(told):
    code, out, _ = told('springs', '--json')
    document = json.loads(out)
    assert code == 0
    assert [round(s['rate']) for s in document['helical']] == [19973, 22570]
    assert 'solid' in document['helical'][1]['failures']
    assert document['leaves'][0]['rate'] == pytest.approx(98.77, abs=5e-3)
    assert 'Table 3' in told('springs')[1]


def test_springs_to_order(told):
    words = ('springs', '--rate', '5500', '--outside', '120', '--length', '300')
    code, out, _ = told(*words, '--deflection', '60', '--limit', '3', '--json')
    document = json.loads(out)
    assert code == 0
    assert len(document['helical']) == 3 < document['found']
    assert all(not s['failures'] for s in document['helical'])
    by_load = json.loads(told(*words, '--load', '330', '--limit', '3', '--json')[1])
    assert by_load['helical'][0]['force'] == pytest.approx(330, rel=0.02)  # the rate's tolerance


def test_leaves_to_order(told):
    words = ('springs', '--kind', 'leaf', '--rate', '2000', '--length', '600', '--load', '260')
    code, out, _ = told(*words)
    assert code == 0
    assert 'ok' in out


@pytest.mark.parametrize(
    'words',
    [
        ('--deflection', '400', '--outside', '20', '--length', '500'),
        ('--kind', 'leaf', '--length', '600', '--load', '26000'),
    ],
)
def test_where_nothing_fits_the_exit_code_is_1(told, words):
    assert told('springs', '--rate', '20000', *words)[0] == 1


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (('--rate', '1e4'), '--rate needs --outside in mm'),
        (('--rate', '1e4', '--outside', '50', '--length', '90'), 'needs either --deflection'),
        (('--rate', '-1', '--outside', '50', '--length', '90', '--load', '1'), 'must be above 0'),
        (('--rate', '1e4', '--kind', 'leaf'), '--kind leaf needs --length'),
        (
            ('--rate', '-1', '--kind', 'leaf', '--length', '60', '--load', '1'),
            '--rate -1 must be above 0',
        ),
    ],
)
def test_a_spring_wish_that_makes_no_sense_is_refused(told, words, said):
    code, out, err = told('springs', *words)
    assert (code, out) == (2, '')
    assert said in err


def test_statics_of_the_geometric_law_are_those_of_single_motions(told):
    code, out, _ = told('statics', '--law', 'geometric', '--json')
    stiffness = json.loads(out)['dofs']['horizontal']['stiffness']
    A, a = PAPER_DESIGN.A, PAPER_DESIGN.a
    assert code == 0
    assert stiffness == pytest.approx(1 + A * (1 - 1 / (2 * a)), abs=1e-12)  # erratum E26


@pytest.mark.parametrize('word', ['hinge', 'cm_height', 'L10'])
def test_statics_refuses_what_only_the_coupled_platform_knows(told, word):
    code, _, err = told('statics', '--law', 'geometric', '--set', f'platform.{word}=0.1')
    assert code == 2
    assert f'platform.{word} = 0.1 has no meaning' in err
    assert 'qzs-rig modes' in err
