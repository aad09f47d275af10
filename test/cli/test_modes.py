"""`qzs-rig modes`: one JSON document, tables, exit codes."""

from __future__ import annotations

import json

import numpy as np
import pytest

from qzs_rig.cli.main import execute
from qzs_rig.mechanics.geometry import SIX


def test_the_document_is_complete_and_consistent(capsys):
    assert execute(['modes', '--set', 'platform.cm_height=0.1', '--json']) == 0
    document = json.loads(capsys.readouterr().out)
    assert document['dofs'] == list(SIX)
    assert document['stable'] is True
    K, M = (np.array(document[name]) for name in ('stiffness', 'mass'))
    for mode in document['modes']:
        shape = np.array(mode['shape'])
        square = shape @ K @ shape / (shape @ M @ shape)
        assert mode['frequency_hz'] == pytest.approx(
            np.sqrt(abs(square)) / (2 * np.pi), rel=1e-9, abs=1e-5
        )
    assert {pair['first'] for pair in document['coupling']} == {'horizontal', 'horizontal_y'}


def test_a_platform_that_falls_over_is_a_finding(capsys):
    assert execute(['modes', '--set', 'platform.hinge=0']) == 1
    text = capsys.readouterr().out
    assert 'FALLS OVER' in text
    assert '1/s grows' in text


def test_a_scenario_gives_the_platform(capsys):
    assert execute(['modes', 'rotations', '--set', 'platform.payload_trim=5']) == 0
    text = capsys.readouterr().out
    assert 'equilibrium from the working point: z -69' in text
    assert 'horizontal - horizontal_rotation' in text


def test_bad_words_are_bad_input(capsys):
    assert execute(['modes', '--set', 'platform.hing=1']) == 2
    assert 'did you mean' in capsys.readouterr().err
