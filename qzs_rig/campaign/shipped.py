"""Plans that ship with the package."""

from __future__ import annotations

from pathlib import Path

from qzs_rig import scenario
from qzs_rig.errors import InputError


def names() -> list[str]:
    """By name, without suffix."""
    return sorted(path.stem for path in _folder().glob('*.yaml'))


def find(plan: str) -> Path:
    """Path of a plan, by name in `config/campaigns` or by path; InputError listing the known."""
    path = Path(plan)
    if path.is_file():
        return path
    known = f'known by name: {", ".join(names())}; or give the path of a YAML file'
    if path.suffix in {'.yaml', '.yml'}:
        raise InputError(f'plan {plan} is not there; {known}')
    shipped = _folder() / f'{plan}.yaml'
    if not shipped.is_file():
        raise InputError(f'unknown plan {plan!r}; {known}')
    return shipped


def headline(name: str) -> str:
    """What a plan is for: the first sentence of its file."""
    comment = find(name).read_text(encoding='utf-8').removeprefix('# ').replace('\n# ', ' ')
    return comment.split('. ')[0].split('\n')[0].rstrip('.')


def _folder() -> Path:
    return scenario.config_folder() / 'campaigns'
