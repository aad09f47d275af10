"""A campaign's plan: read from YAML, checked to the last word, and cut into chunks."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from qzs_rig import __version__, scenario
from qzs_rig.campaign.axes import MOST, axis_of, mapping, refuse_unknown, whole
from qzs_rig.campaign.sampling import Grid, Sample, columns, latin_hypercube
from qzs_rig.campaign.task import Points, Task
from qzs_rig.campaign.tasks import TASKS
from qzs_rig.errors import InputError
from qzs_rig.parameters import Parameter, RunSpec, closest, unknown_parameter, yaml_document

SECTIONS = ('campaign', 'base', 'vary', 'options')
KEYS = ('task', 'seed', 'sample', 'samples', 'place', 'method', 'chunk')
SAMPLES = ('grid', 'latin_hypercube')
MOST_POINTS = 1_000_000_000
FEW = 16
"""Chunks in which even a small campaign is cut: all cores have work, a crash loses little."""


@dataclass(frozen=True)
class Plan:
    """One task over all points of a sample. `fixed` holds what all points share."""

    task: Task
    sample: Sample
    fixed: RunSpec
    options: RunSpec
    seed: int
    chunk: int

    @property
    def points(self) -> int:
        """How many there are."""
        return self.sample.points

    @property
    def chunks(self) -> int:
        """How many there are; the last may be shorter."""
        return -(-self.points // self.chunk)

    @property
    def chunk_bytes(self) -> int:
        """Bytes of figures of a chunk: what a worker sends back, and what a chunk's file holds."""
        return self.chunk * (8 * len(self.task.outputs) + 4)

    @property
    def varied(self) -> tuple[str, ...]:
        """Names of the axes."""
        return tuple(axis.parameter.name for axis in self.sample.axes)

    def part(self, number: int) -> tuple[int, int]:
        """First point of chunk `number`, and the one after its last."""
        first = number * self.chunk
        return first, min(first + self.chunk, self.points)

    def between(self, first: int, stop: int) -> Points:
        """The points first … stop - 1."""
        varied = columns(self.sample, first, stop)
        return Points(self._typical, varied, first, stop - first, self.seed)

    @cached_property
    def _typical(self) -> RunSpec:
        first = columns(self.sample, 0, 1)
        return self.fixed.override({name: column[0].item() for name, column in first.items()})

    @cached_property
    def document(self) -> dict[str, Any]:
        """All of the plan, JSON-ready: `of(plan.document)` is this plan, on any machine."""
        return {
            'campaign': {
                'task': self.task.name,
                'seed': self.seed,
                **self.sample.to_document(),
                'chunk': self.chunk,
            },
            'base': dict(self.fixed.given),
            'vary': {axis.parameter.name: axis.to_document() for axis in self.sample.axes},
            'options': dict(self.options),
        }

    @property
    def text(self) -> str:
        """The document as one line that is the same for the same plan."""
        return json.dumps(self.document, allow_nan=False)

    @property
    def fingerprint(self) -> str:
        """Eight characters that differ where plan or version differ."""
        return hashlib.sha256(f'{self.text}{__version__}'.encode()).hexdigest()[:8]


def load(path: Path, assignments: Mapping[str, Any] = {}) -> Plan:
    """The plan in a YAML file, with `assignments` on top of its `base`; raises InputError."""
    return of(yaml_document(path, 'plan'), assignments)


def of(document: Any, assignments: Mapping[str, Any] = {}) -> Plan:
    """The plan in a parsed document; raises InputError naming what is wrong with it."""
    sections = mapping(document, 'a plan')
    refuse_unknown(sections, SECTIONS, 'plan')
    head = mapping(sections.get('campaign'), 'campaign')
    refuse_unknown(head, KEYS, 'campaign')
    task = _task(head.get('task'))
    seed = whole('campaign: seed', head.get('seed', 0), 2**31 - 1, 0)
    explicit = {**mapping(sections.get('base'), 'base'), **assignments}
    declared = (*scenario.PARAMETERS, *task.inputs)
    sample = _sample(head, seed, declared, mapping(sections.get('vary'), 'vary'))
    fixed = _fixed(declared, explicit, sample)
    options = mapping(sections.get('options'), 'options')
    refuse_unknown(options, (item.name for item in task.options), f'options of {task.name}')
    plan = Plan(
        task,
        sample,
        fixed,
        RunSpec.of(task.options, dict(RunSpec.of(task.options, options))),
        seed,
        whole('campaign: chunk', head.get('chunk', _chunk(task, sample.points)), MOST),
    )
    _check(plan)
    return plan


def shipped() -> list[str]:
    """Names of the plans that ship with the package."""
    return sorted(path.stem for path in _folder().glob('*.yaml'))


def find(plan: str) -> Path:
    """Path of a plan, by name in `config/campaigns` or by path; InputError listing the known."""
    path = Path(plan)
    if path.is_file():
        return path
    known = f'known by name: {", ".join(shipped())}; or give the path of a YAML file'
    if path.suffix in {'.yaml', '.yml'}:
        raise InputError(f'plan {plan} is not there; {known}')
    path = _folder() / f'{plan}.yaml'
    if not path.is_file():
        raise InputError(f'unknown plan {plan!r}; {known}')
    return path


def headline(name: str) -> str:
    """What a plan is for: the first sentence of its file."""
    comment = find(name).read_text(encoding='utf-8').removeprefix('# ').replace('\n# ', ' ')
    return comment.split('. ')[0].split('\n')[0].rstrip('.')


def _folder() -> Path:
    return scenario.config_folder() / 'campaigns'


def _task(name: Any) -> Task:
    if name is None:
        raise InputError(f'campaign: task is missing; give one of {", ".join(TASKS)}')
    if name not in TASKS:
        raise InputError(
            f'campaign: task {name!r} is unknown{closest(str(name), TASKS)}; give one of '
            f'{", ".join(TASKS)}'
        )
    return TASKS[name]


def _chunk(task: Task, points: int) -> int:
    """The task's, or less where there are few points; the same wherever the plan is read."""
    blocks = -(-points // (FEW * task.block))
    return min(task.chunk, blocks * task.block)


def _fixed(declared: tuple[Parameter, ...], explicit: Mapping[str, Any], sample: Sample) -> RunSpec:
    """The fixed values: a scenario's, silenced by what the plan fixes and varies by name."""
    named = explicit.get('scenario')
    given = {name: value for name, value in explicit.items() if name != 'scenario'}
    varied = {name: column[0].item() for name, column in columns(sample, 0, 1).items()}
    twice = sorted(set(varied) & set(given))
    if twice:
        raise InputError(f'{twice[0]} is fixed and varied; keep it in base or in vary')
    under = scenario.load(str(named)).given if named else {}
    # together, so that two words for one thing are refused, and those of the scenario silenced
    spec = RunSpec.of(declared, under).override({**given, **varied})
    return RunSpec(declared, {n: v for n, v in spec.given.items() if n not in varied})


def _sample(
    head: dict[str, Any], seed: int, declared: tuple[Parameter, ...], vary: dict[str, Any]
) -> Sample:
    kind = head.get('sample', 'grid')
    if kind not in SAMPLES:
        raise InputError(f'campaign: sample {kind!r} is unknown; give one of {", ".join(SAMPLES)}')
    if not vary:
        raise InputError('vary is empty; name at least one parameter and its values')
    table = {item.name: item for item in declared}
    for name in vary:
        if name not in table:
            raise InputError(unknown_parameter(name, table))
    grid = kind == 'grid'
    axes = tuple(axis_of(table[name], given, grid) for name, given in vary.items())
    if not grid:
        samples = whole('campaign: samples', head.get('samples'), MOST)
        words = {key: head[key] for key in ('place', 'method') if key in head}
        return latin_hypercube(axes, samples, seed, **words)
    for key in ('samples', 'place', 'method'):
        if key in head:
            raise InputError(f'campaign: {key} is for sample: latin_hypercube; leave it out')
    return Grid(axes)


def _check(plan: Plan) -> None:
    if plan.points > MOST_POINTS:
        raise InputError(
            f'the grid has {plan.points:.3g} points, beyond {MOST_POINTS:g}; thin it, or take a '
            'latin_hypercube'
        )
    typical = plan.between(0, 1)
    for group in plan.task.needed:
        if not any(name in typical.fixed for name in group):
            raise InputError(
                f'task {plan.task.name} needs {" or ".join(group)}; put it under base or vary'
            )
