"""Scenarios: every shipped file loads, by name or path, with words on top."""

from __future__ import annotations

import shutil

import pytest

from qzs_rig import scenario
from qzs_rig.errors import InputError, LimitError
from qzs_rig.mechanics.platform import Platform
from qzs_rig.parameters import RunSpec, read_yaml
from qzs_rig.run.stages import ExciterStage


@pytest.mark.parametrize('name', scenario.names())
def test_every_scenario_loads_builds_and_survives_its_yaml(name, tmp_path):
    spec = scenario.load(name)
    Platform.from_spec(spec)
    try:
        ExciterStage(spec, scenario.step_ns_of(spec))
    except LimitError:
        assert name == 'paper_test'
    path = tmp_path / 'again.yaml'
    path.write_text(spec.to_yaml(), encoding='utf-8')
    assert RunSpec.of(scenario.parameters(), read_yaml(path)) == spec
    assert scenario.load(str(path)) == spec


def test_the_default_scenario_ships():
    assert scenario.DEFAULT in scenario.names()


def test_words_on_top_of_a_file():
    spec = scenario.load('rotations', ['platform.L0=0.05', 'run.rate=250', 'shaker.limits=false'])
    assert spec['platform.L0'] == 0.05
    assert 'platform.L0_hat' not in spec  # the file's synonym is silenced
    assert (spec['run.rate'], spec['shaker.limits']) == (250.0, False)


def test_a_word_given_twice_is_refused():
    with pytest.raises(InputError, match=r'--set run\.seed is given twice; keep one'):
        scenario.load('rotations', ['run.seed=1', 'run.seed=2'])


def test_an_unknown_name_lists_the_known():
    with pytest.raises(InputError, match=r"unknown scenario 'nope'; known: .*vertical_sweep.*path"):
        scenario.load('nope')


def test_a_path_that_is_not_there_lists_the_known_names():
    with pytest.raises(InputError, match=r'nope\.yaml is not there; known by name: .*rotations'):
        scenario.load('nope.yaml')


def test_a_folder_of_the_same_name_does_not_hide_a_scenario(tmp_path, monkeypatch):
    (tmp_path / 'rotations').mkdir()
    monkeypatch.chdir(tmp_path)
    assert scenario.find('rotations').suffix == '.yaml'


def test_a_file_without_suffix_is_a_path(tmp_path):
    path = tmp_path / 'mine'
    path.write_text(scenario.of({'run.seed': 9}).to_yaml(), encoding='utf-8')
    assert scenario.load(str(path))['run.seed'] == 9


def test_the_step_is_whole_nanoseconds():
    assert scenario.step_ns_of(scenario.of({'run.rate': 500.0})) == 2_000_000
    assert scenario.step_ns_of(scenario.of({'run.rate': 300.0})) == 3_333_333


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """The module as if installed in `tmp_path`, where no config is near."""
    module = tmp_path / 'prefix' / 'lib' / 'python3' / 'site-packages' / 'qzs_rig' / 'scenario.py'
    monkeypatch.setattr(scenario, '__file__', str(module))
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    shipped = scenario.Path(__file__).parent.parent / 'config'
    return lambda folder: shutil.copytree(shipped, folder)


def test_config_of_a_wheel(installed, tmp_path):
    folder = tmp_path / 'prefix' / 'share' / 'qzs_rig' / 'config'
    installed(folder)
    assert scenario.config_folder() == folder


def test_config_of_an_ament_install(installed, tmp_path, monkeypatch):
    folder = tmp_path / 'ws' / 'share' / 'qzs_rig' / 'config'
    installed(folder)
    monkeypatch.setenv('AMENT_PREFIX_PATH', f'/nowhere:{tmp_path / "ws"}')
    assert scenario.config_folder() == folder
    assert 'rotations' in scenario.names()


def test_a_missing_config_folder_says_what_to_do(installed):
    with pytest.raises(
        InputError, match=r'no config folder with vertical_sweep\.yaml .* reinstall'
    ):
        scenario.config_folder()
