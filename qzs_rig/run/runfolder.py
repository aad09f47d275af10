"""The folder of a run: where it is and what is in it."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from qzs_rig import files, wire
from qzs_rig.bag import BagWriter, TopicSpec
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.prediction import curve, labels
from qzs_rig.prediction.curve import Prediction
from qzs_rig.run.sheet import RunSheet
from qzs_rig.samples import Stamps
from qzs_rig.wire import Bytes


class Recording:
    """The bag of one run: messages as they are, at the times of their stamps (n,).

    `messages` are n serialised ones, in a sequence or, of one length, as rows (n, length).
    """

    def __init__(self, folder: Path, base_topic: str, top_topic: str) -> None:
        """Opens `folder` as a new bag with `base/motion`, the two Imu topics and `rig/run`."""
        imus = (wire.BASE_IMU._replace(name=base_topic), wire.TOP_IMU._replace(name=top_topic))
        topics = (wire.BASE_MOTION, *imus, wire.RUN)
        self.folder = folder
        self._base, self._top = base_topic, top_topic
        self._writer = BagWriter(folder, [TopicSpec(*topic[:4]) for topic in topics])

    def sheet(self, stamp_ns: int, sheet: RunSheet) -> None:
        """Keep the run sheet."""
        self._writer.write(wire.RUN.name, [stamp_ns], [wire.encode_json(sheet.to_document())])

    def motion(self, stamps_ns: Sequence[int] | Stamps, messages: Sequence[bytes] | Bytes) -> None:
        """Keep chunks of base motion."""
        self._writer.write(wire.BASE_MOTION.name, stamps_ns, messages)

    def base(self, stamps_ns: Stamps, messages: Sequence[bytes] | Bytes) -> None:
        """Keep messages of the base sensor."""
        self._writer.write(self._base, stamps_ns, messages)

    def top(self, stamps_ns: Stamps, messages: Sequence[bytes] | Bytes) -> None:
        """Keep messages of the top sensor."""
        self._writer.write(self._top, stamps_ns, messages)

    def tick(self) -> None:
        """Hand over what has waited long enough."""
        self._writer.tick()

    def close(self) -> None:
        """Finish the bag; a second call does nothing."""
        self._writer.close()


ROOT = 'runs'
SCHEMA = 'qzs_rig/run/1'


def new_folder(scenario: str, run_id: str, root: str = ROOT) -> Path:
    """`runs/<time>_<scenario>_<id>`, not created yet."""
    name = Path(scenario).stem or 'run'
    return Path(root) / f'{time.strftime("%Y%m%d-%H%M%S")}_{name}_{run_id}'


def keep_results(
    folder: Path,
    sheet: RunSheet,
    estimate: Estimate,
    predictions: Sequence[Prediction],
    *,
    rig_s: float,
    wall_s: float,
    topics: Mapping[str, Mapping[str, int]],
    bag: Path | None,
    report: Path | None = None,
) -> dict[str, Any]:
    """Write estimate.json, theory and run.json of a run that ended as `sheet` says; returns the
    document in run.json, which `--json` prints.

    `topics` holds counts of samples: published, received, lost, duplicated. `report` is where one
    will be.
    """
    path = files.write_new(folder / 'estimate.json', estimate.to_json() + '\n')
    if predictions:
        keep_theory(folder, sheet.run_id, predictions, estimate)
    document = {
        'schema': SCHEMA,
        'run_id': sheet.run_id,
        'mode': sheet.mode,
        'rig_s': rig_s,
        'wall_s': wall_s,
        'topics': topics,
        'bag': str(bag) if bag else None,
        'estimate': str(path),
        'report': str(report) if report else None,
        'state': sheet.state.value,
        'reason': sheet.reason,
        'scenario': sheet.scenario,
    }
    files.write_new_json(folder / 'run.json', document)
    return document


def keep_theory(
    folder: Path, run_id: str, predictions: Sequence[Prediction], estimate: Estimate
) -> None:
    """`theory.json`, and `match.json`: on which branch of it every measured point lies."""
    theory = curve.to_document(run_id, predictions)
    match = labels.to_document(run_id, labels.label_all(estimate, predictions))
    for name, content in (('theory.json', theory), ('match.json', match)):
        files.write_new(folder / name, json.dumps(content, allow_nan=False) + '\n')


def theory_in(folder: Path) -> tuple[Prediction, ...] | None:
    """The predictions that a run kept, None where it kept none."""
    path = folder / 'theory.json'
    if not path.is_file():
        return None
    return curve.from_document(json.loads(path.read_text(encoding='utf-8')))
