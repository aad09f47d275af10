"""What the paper's four frequencies fix."""

from __future__ import annotations

import numpy as np
import pytest

from qzs_rig.errors import InputError
from qzs_rig.identification import jumps
from qzs_rig.identification.fit_report import jumps_document, jumps_text
from qzs_rig.theory.balance.frequency_response import frequency_response
from qzs_rig.theory.oscillator import Oscillator


@pytest.fixture(scope='module')
def found():
    return jumps.fixed_by(jumps.paper_spec({}), jumps.PAPER, jumps.PAPER_UNKNOWNS)


def test_a_platform_that_jumps_there_is_found(found):
    assert found.predicted_hz == pytest.approx([2.22, 1.90, 4.43, 4.12], abs=1e-3)
    there = Oscillator.driven(found.unknowns.applied(found.values), 'vertical')
    answer = frequency_response(there, 0.3, 1.5, isolas=False)
    hz = sorted(fold.omega * there.hertz for fold in answer.folds)
    # nine harmonics against as many as it takes
    assert hz == pytest.approx([1.90, 2.22], rel=2e-3)


def test_four_frequencies_fix_combinations_and_no_parameter(found):
    assert 1 <= len(found.fixed) <= 4
    assert [d.std for d in found.directions][4:] > [1e3, 1e3]
    assert found.determined == []
    document = jumps_document(found)
    assert not any(item['determined'] for item in document['parameters'])
    assert 'no parameter by itself' in jumps_text(found)


def test_the_best_known_combination_is_fixed(found):
    """Along the free combinations the jumps stay, along the best known they go."""
    reference = found.unknowns.reference

    def jump_hz(change):
        spec = found.unknowns.applied(found.values + change * reference)
        there = Oscillator.driven(spec, 'vertical')
        answer = frequency_response(there, 0.3, 1.5, isolas=False)
        return max(fold.omega for fold in answer.folds) * there.hertz

    best, free = found.directions[0].weights, found.directions[-1].weights
    # a linear statement: small steps of the same length
    along_best = abs(jump_hz(3e-4 * best / np.linalg.norm(best)) - jump_hz(0 * best))
    along_free = abs(jump_hz(3e-4 * free / np.linalg.norm(free)) - jump_hz(0 * free))
    assert along_free < 0.1 * along_best


def test_one_parameter_is_determined_by_its_jump():
    one = jumps.Jump('vertical', 'jump_up', 2.2, 0.05)
    found = jumps.fixed_by(jumps.paper_spec({}), [one], ('platform.k1',))
    assert found.determined == ['platform.k1']
    assert 'but platform.k1' in jumps_text(found)


def test_a_platform_without_jumps_is_refused():
    damped = jumps.paper_spec({'platform.zeta': 0.9})
    with pytest.raises(InputError, match='jumps nowhere'):
        jumps.fixed_by(damped, jumps.PAPER, ('platform.A',))
