"""Imports point downward only, and heavy packages stay behind the door of their layer."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import qzs_rig

ROOT = Path(qzs_rig.__file__).parent

LAYERS = (
    {'__init__', 'errors', 'units'},
    {'files', 'samples', 'parameters'},
    {'excitation', 'mechanics', 'sensing', 'estimation'},
    {'scenario', 'theory', 'wire', 'bag'},
    {'prediction'},
    {'run', 'loopback'},
    {'report', 'ros'},
    {'compare', 'claims'},
    {'design', 'identification'},
    {'campaign'},
    {'cli'},
)
"""From the ground up. A module imports from the layers below its own, and from its own package."""

NEVER = {
    'estimation': {'mechanics', 'theory', 'excitation', 'sensing'},
    'mechanics': {'excitation', 'sensing'},
    'theory': {'excitation', 'sensing'},
    'wire': {'parameters', 'mechanics'},
    'bag': {'wire', 'parameters', 'mechanics', 'estimation', 'theory'},
    'ros': {'compare', 'theory', 'mechanics', 'excitation', 'sensing'},
    'cli': {'ros'},
}
"""What a package leaves alone though it lies below: the seams of the design. The CLI starts nodes
as processes; the only word of the bag that ROS knows is the reader of the player."""

HOMES = {
    'rclpy': {'ros'},
    'rosbags': {'bag', 'wire'},
    'mcap': {'bag'},
    'zstandard': {'bag'},
    'bokeh': {'report'},
    'matplotlib': {'report'},
    'numba': {'mechanics', 'theory'},
    'threadpoolctl': {'theory'},
    'tqdm': {'cli'},
    'dask': {'campaign'},
    'distributed': {'campaign'},
    'pyarrow': {'campaign'},
    'scipy': {'campaign', 'identification', 'prediction', 'theory'},
    'pandas': set(),
}
"""The only packages that may import a dependency; messages of ROS count as rclpy."""

MODULES = sorted(ROOT.rglob('*.py'))
PLAIN = ('errors', 'parameters', 'samples', 'scenario', 'run.in_process', 'run.sheet', 'wire')


def package_of(path: Path) -> str:
    return path.relative_to(ROOT).parts[0].removesuffix('.py')


def imports(path: Path) -> Iterator[str]:
    """Every imported module of a file, wherever the import stands; relative ones are not used."""
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path}: relative import'
            assert node.module
            if node.module == 'qzs_rig':
                yield from (f'qzs_rig.{alias.name}' for alias in node.names)
            else:
                yield node.module


def ours(path: Path) -> set[str]:
    words = (name.split('.') for name in imports(path))
    known = {package_of(module) for module in MODULES}
    # `from qzs_rig import __version__` imports the package itself
    return {
        word[1] if len(word) > 1 and word[1] in known else '__init__'
        for word in words
        if word[0] == 'qzs_rig'
    }


def level(package: str) -> int:
    return next(number for number, layer in enumerate(LAYERS) if package in layer)


def test_every_package_has_its_layer():
    assert {package_of(path) for path in MODULES} == set().union(*LAYERS)


@pytest.mark.parametrize('path', MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_downward(path):
    here = package_of(path)
    for there in ours(path) - {here}:
        assert level(there) < level(here), f'{here} imports {there}'
        assert there not in NEVER.get(here, set()), f'{here} must not know {there}'


@pytest.mark.parametrize('path', MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_dependencies_stay_in_their_home(path):
    for name in imports(path):
        root = name.split('.')[0]
        if root.startswith(('rclpy', 'rcl_', 'launch', 'ament')) or root.endswith(
            ('_msgs', '_interfaces')
        ):
            root = 'rclpy'
        assert package_of(path) in HOMES.get(root, {package_of(path)}), f'{path} imports {name}'


def test_ros_knows_the_bag_only_through_its_reader():
    users = {path.name for path in MODULES if package_of(path) == 'ros' and 'bag' in ours(path)}
    assert users <= {'player.py'}


def loaded_by(statement: str) -> set[str]:
    """Top-level packages that a fresh interpreter has loaded after `statement`."""
    # the wheels' .pth may load parts of ROS at start-up: only what the statement adds counts
    program = (
        f'import sys; before = set(sys.modules); {statement}; '
        "print(*{name.split('.')[0] for name in set(sys.modules) - before})"
    )
    run = subprocess.run(
        [sys.executable, '-c', program], capture_output=True, text=True, check=True, timeout=60
    )
    return set(run.stdout.split())


def test_the_physics_loads_no_middleware_and_no_plotting():
    names = [f'qzs_rig.{name}' for name in PLAIN]
    names += ['qzs_rig.run.stages', 'qzs_rig.theory.motion.stroboscope']
    names += ['qzs_rig.mechanics.integrator', 'qzs_rig.theory.single_term', 'qzs_rig.excitation']
    loaded = loaded_by(f'import qzs_rig, {", ".join(names)}')
    assert 'numpy' in loaded
    heavy = {'rclpy', 'rosbags', 'mcap', 'bokeh', 'matplotlib', 'numba', 'scipy', 'tqdm', 'yaml'}
    assert not loaded & heavy


def test_the_package_itself_loads_nothing():
    assert loaded_by('import qzs_rig') == {'qzs_rig'}


@pytest.mark.parametrize(('awaited', 'compiled'), [(2001, False), (120_002, True)])
def test_compiled_code_is_loaded_where_it_pays(awaited, compiled):
    loaded = loaded_by(
        'from qzs_rig import scenario; from qzs_rig.run.stages import PlatformStage; '
        f'PlatformStage(scenario.of({{}}), 1_000_000, {awaited})'
    )
    assert ('numba' in loaded) == compiled
