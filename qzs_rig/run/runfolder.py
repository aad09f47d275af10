"""The folder of a run: where it is and what is in it."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from qzs_rig import files
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.prediction import curve, labels
from qzs_rig.prediction.curve import Prediction

ROOT = 'runs'
SCHEMA = 'qzs_rig/run/1'


def new_folder(scenario: str, run_id: str, root: str = ROOT) -> Path:
    """`runs/<time>_<scenario>_<id>`, not created yet."""
    name = Path(scenario).stem or 'run'
    return Path(root) / f'{time.strftime("%Y%m%d-%H%M%S")}_{name}_{run_id}'


def run_document(
    run_id: str,
    mode: str,
    rig_s: float,
    wall_s: float,
    topics: dict[str, dict[str, int]],
    files: dict[str, Path | None],
    **more: Any,
) -> dict[str, Any]:
    """What `--json` prints and `run.json` holds; `files` are bag, estimate and report."""
    paths = {name: str(path) if path else None for name, path in files.items()}
    return {
        'schema': SCHEMA,
        'run_id': run_id,
        'mode': mode,
        'rig_s': rig_s,
        'wall_s': wall_s,
        'topics': topics,
        **paths,
        **more,
    }


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
