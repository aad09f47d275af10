"""Analysis after the fact: the same estimator over a bag, with the same bits as the live run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from qzs_rig import scenario, wire
from qzs_rig.bag import BagReader
from qzs_rig.errors import BagError, InputError
from qzs_rig.estimation.estimate import Estimate, from_json
from qzs_rig.parameters import RunSpec, parse_assignment
from qzs_rig.run.sheet import RunSheet, from_document
from qzs_rig.run.stages import AnalyzerStage
from qzs_rig.samples import Samples

CHUNK = 5000


@dataclass(frozen=True)
class Analysis:
    """An estimate with what is known of the run it came from; no sheet for a foreign bag."""

    estimate: Estimate
    spec: RunSpec
    sheet: RunSheet | None


def analyze(path: Path, assignments: Sequence[str] = ()) -> Analysis:
    """Estimate from the Imu topics of the bag at `path`; `--set` words change the analyzer."""
    with BagReader(path) as reader:
        sheet = last_sheet(reader)
        spec = _spec(sheet, assignments)
        names = [spec.text(f'analyzer.{plate}.topic') for plate in ('base', 'top')]
        base, top = (_readings(reader, name) for name in names)
    stage = AnalyzerStage(spec, sheet.step_ns or None if sheet else None)
    _feed(stage, base, top)
    return Analysis(stage.result(), spec, sheet)


def recorded(path: Path) -> Analysis:
    """The estimate at `path`: an estimate.json, a run folder with one, or a bag to analyze."""
    file = path / 'estimate.json' if path.is_dir() else path
    if file.suffix != '.json':
        return analyze(path)
    if not file.is_file():
        if path.is_dir():
            return analyze(path)
        raise InputError(f'{path} is not there; give a bag, a run folder or an estimate.json')
    estimate = from_json(file.read_text(encoding='utf-8'))
    try:
        reader = BagReader(file.parent)
    except BagError:
        return Analysis(estimate, scenario.of({}), None)  # an estimate moved away from its bag
    with reader:
        sheet = last_sheet(reader)
    return Analysis(estimate, _spec(sheet, ()), sheet)


def recorded_spec(path: Path, assignments: Sequence[str] = ()) -> RunSpec:
    """The parameters of the run recorded at `path`; the defaults where it holds no run sheet."""
    with BagReader(path) as reader:
        return _spec(last_sheet(reader), assignments)


def last_sheet(reader: BagReader) -> RunSheet | None:
    """How the recorded run ended; None where the bag holds no run sheet."""
    sheets = [from_document(document) for document in reader.run_sheets()]
    return sheets[-1] if sheets else None


def _spec(sheet: RunSheet | None, assignments: Sequence[str]) -> RunSpec:
    spec = scenario.complete(sheet.spec) if sheet else scenario.of({})
    return spec.override(dict(parse_assignment(text) for text in assignments))


def _readings(reader: BagReader, topic: str) -> Samples:
    rows = reader.rows(topic, wire.BASE_IMU.type)
    return wire.decode_imu(rows.rows if len(rows) and rows.equal else rows.messages())


def _feed(stage: AnalyzerStage, base: Samples, top: Samples) -> None:
    for first in range(0, max(len(base), len(top)), CHUNK):
        stage.push_base(base[first : first + CHUNK])
        stage.push_top(top[first : first + CHUNK])
