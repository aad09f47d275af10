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
from qzs_rig.campaign.axes import MOST, axis_of, checked
from qzs_rig.campaign.sampling import METHOD, PLACES, Grid, LatinHypercube, Sample, columns
from qzs_rig.campaign.task import Points, Task
from qzs_rig.campaign.tasks import TASKS
from qzs_rig.errors import InputError
from qzs_rig.parameters import Parameter, RunSpec, closest, unknown_parameter, yaml_document

FOLDER = 'campaigns'
"""Of the plans that ship, in `config/`."""
SECTIONS = ('campaign', 'base', 'vary', 'options')
OF_HYPERCUBE = (
    Parameter('samples', int, None, '', 'points of a latin_hypercube', 1, MOST),
    Parameter('place', str, 'centre', '', 'of a sample in its stratum', choices=PLACES),
    Parameter('method', str, METHOD, '', 'by which samples are drawn', choices=(METHOD,)),
)
HEAD = (
    Parameter('task', str, None, '', 'what is computed at each point', choices=tuple(TASKS)),
    Parameter('seed', int, 0, '', 'of samples and of sensor noise', 0, 2**31 - 1),
    Parameter('sample', str, 'grid', '', 'the points', choices=('grid', 'latin_hypercube')),
    *OF_HYPERCUBE,
    Parameter('chunk', int, None, 'points', 'kept together; unset: as the task says', 1, MOST),
)
"""What the section `campaign` of a plan says."""
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
        """Number of points of the whole campaign."""
        return self.sample.points

    @property
    def chunks(self) -> int:
        """Number of chunks of `chunk` points; the last may be shorter."""
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
    sections = _mapping(document, 'a plan')
    for key in sections:
        if key not in SECTIONS:
            raise InputError(
                f'plan: unknown key {key!r}{closest(key, SECTIONS)}; known: {", ".join(SECTIONS)}'
            )
    base, vary, options = (_mapping(sections.get(name), name) for name in SECTIONS[1:])
    head = checked('campaign', HEAD, _mapping(sections.get('campaign'), 'campaign'))
    if 'task' not in head:
        raise InputError(f'campaign: task is missing; give one of {", ".join(TASKS)}')
    task = TASKS[head.text('task')]
    declared = (*scenario.parameters(), *task.inputs)
    sample = _sample(head, declared, vary)
    settings = checked(f'options of {task.name}', task.options, options)
    plan = Plan(
        task,
        sample,
        _fixed(declared, {**base, **assignments}, sample),
        RunSpec.of(task.options, dict(settings)),  # with the defaults: they are part of the plan
        head.count('seed'),
        head.count('chunk') if 'chunk' in head else _chunk(task, sample.points),
    )
    _check(plan)
    return plan


def _mapping(given: Any, where: str) -> dict[str, Any]:
    """`given` as a map of names, an absent one empty; InputError for anything else."""
    if given is None:
        return {}
    if not isinstance(given, dict) or not all(isinstance(key, str) for key in given):
        raise InputError(f'{where} must map names to values, as in "name: value"')
    return given


def shipped() -> dict[str, str]:
    """Plans that ship with the package, by name, and what each is for."""
    return scenario.headlines(FOLDER)


def find(plan: str) -> Path:
    """Path of a plan, by name or by path; InputError listing the known."""
    return scenario.find(plan, 'plan', FOLDER)


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


def _sample(head: RunSpec, declared: tuple[Parameter, ...], vary: dict[str, Any]) -> Sample:
    if not vary:
        raise InputError('vary is empty; name at least one parameter and its values')
    table = {item.name: item for item in declared}
    for name in vary:
        if name not in table:
            raise InputError(unknown_parameter(name, table))
    grid = head.text('sample') == 'grid'
    axes = tuple(axis_of(table[name], given, grid) for name, given in vary.items())
    if grid:
        for item in OF_HYPERCUBE:
            if item.name in head.given:
                raise InputError(
                    f'campaign: {item.name} is for sample: latin_hypercube; leave it out'
                )
        return Grid(axes)
    if 'samples' not in head:
        raise InputError('campaign: samples is missing; say how many points the hypercube has')
    return LatinHypercube(axes, head.count('samples'), head.count('seed'), head.text('place'))


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
