"""Kernels made of a template and formulas: the same values compiled, and known by what they do."""

from __future__ import annotations

import subprocess
import sys

from qzs_rig.mechanics.specialise import compiled, fingerprint, interpreted

SCALE = 2.0


def inner(x):
    raise AssertionError('a template stands for nothing by itself')


def template(x):
    return 3.0 * inner(x)


def doubled(x):
    return SCALE * x


def by(factor):
    def scaled(x):
        return factor * x

    return scaled


def test_compiled_gives_what_interpreted_gives():
    for formula in (doubled, by(5.0), by(7.0)):
        assert compiled(template, {'inner': formula})(1.5) == 3.0 * formula(1.5)
        assert interpreted(template, {'inner': formula})(1.5) == 3.0 * formula(1.5)


def test_a_compiled_formula_may_go_into_another():
    half = compiled(template, {'inner': doubled})
    assert compiled(template, {'inner': half})(1.0) == 3.0 * 3.0 * 2.0


def test_what_computes_differently_has_another_fingerprint(monkeypatch):
    assert fingerprint(by(5.0)) == fingerprint(by(5.0))
    assert fingerprint(by(5.0)) != fingerprint(by(7.0))
    before = fingerprint(doubled)
    monkeypatch.setitem(globals(), 'SCALE', 4.0)
    assert fingerprint(doubled) != before


def test_a_kernel_has_the_same_name_in_every_process():
    program = (
        'from qzs_rig.mechanics.restoring import roots\n'
        'from qzs_rig.mechanics.specialise import compiled\n'
        "words = {'contract', 'reassoc', 'arcp', 'afn', 'nsz'}\n"
        'print(compiled(roots.rsqrt, {}, fastmath=words).__name__)'
    )
    names = {
        subprocess.run(
            [sys.executable, '-c', program],
            capture_output=True,
            text=True,
            check=True,
            env={'PYTHONHASHSEED': seed, 'PYTHONPATH': ':'.join(sys.path)},
        ).stdout
        for seed in ('1', '2')
    }
    assert len(names) == 1
