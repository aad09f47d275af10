"""The finished table: one row a point, written column by column, with the plan inside.

What is varied comes first, then the outputs, then `reason`: '' or why the row has no figures. In
NPZ `reason` is a number into `reasons`, and `about` holds the description that Parquet keeps
as metadata under `qzs_rig`. The same plan gives the same bytes, however it was computed.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

import numpy as np

from qzs_rig import __version__
from qzs_rig.campaign.axes import Column
from qzs_rig.campaign.finished import SCHEMA, Finished
from qzs_rig.campaign.ledger import Ledger
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.task import Codes
from qzs_rig.errors import InputError
from qzs_rig.files import rewriting

FORMATS = ('npz', 'parquet')
GROUP = 65_536
"""Rows of a Parquet row group, where chunks are smaller."""
NEVER = (1980, 1, 1, 0, 0, 0)
"""Date of everything in the ZIP file."""


def format_of(wanted: str | None) -> str:
    """The format `wanted`, or where nobody names one Parquet if pyarrow is installed; InputError
    where it is wanted and is not."""
    installed = find_spec('pyarrow') is not None
    if wanted == 'parquet' and not installed:
        raise InputError("Parquet needs pyarrow: pip install 'qzs_rig[campaign]', or --format npz")
    return wanted or ('parquet' if installed else 'npz')


def write(ledger: Ledger, kind: str) -> Finished:
    """The table of a complete ledger; memory holds one chunk of one column, or
    a row group of Parquet."""
    path = ledger.folder / f'table.{kind}'
    with rewriting(path) as draft:
        (_write_npz if kind == 'npz' else _write_parquet)(ledger, _reasons(ledger), draft)
    return Finished(path)


def about(plan: Plan) -> dict[str, Any]:
    """What a reader needs to know of a table."""
    varied = {
        a.parameter.name: {'unit': a.parameter.unit, 'text': a.parameter.text}
        for a in plan.sample.axes
    }
    outputs = {o.name: {'unit': o.unit, 'text': o.text} for o in plan.task.outputs}
    return {
        'schema': SCHEMA,
        'version': __version__,
        'points': plan.points,
        'plan': plan.document,
        'varied': varied,
        'outputs': outputs,
    }


def _reasons(ledger: Ledger) -> list[str]:
    """All reasons, in order of chunks; the first is ''."""
    found: dict[str, None] = {'': None}
    for number in range(ledger.plan.chunks):
        found.update(dict.fromkeys(ledger.column(number, 'reasons').tolist()))
    return list(found)


def _codes(ledger: Ledger, reasons: list[str], number: int) -> Codes:
    """Codes of a chunk in the table's numbering."""
    place = {reason: code for code, reason in enumerate(reasons)}
    own = [place[reason] for reason in ledger.column(number, 'reasons').tolist()]
    codes: Codes = np.array(own, dtype=np.int32)[ledger.column(number, 'code')]
    return codes


def _columns(ledger: Ledger, reasons: list[str]) -> dict[str, Callable[[int], Column]]:
    """Every column of the table as a function of the chunk."""
    plan = ledger.plan

    def varied(axis: int) -> Callable[[int], Column]:
        return lambda number: plan.sample.column(axis, *plan.part(number))

    def output(name: str) -> Callable[[int], Column]:
        return lambda number: ledger.column(number, name)

    return {
        **{name: varied(axis) for axis, name in enumerate(plan.varied)},
        **{name: output(name) for name in plan.task.columns},
        'reason': lambda number: _codes(ledger, reasons, number),
    }


def _write_npz(ledger: Ledger, reasons: list[str], path: Path) -> None:
    plan = ledger.plan
    with zipfile.ZipFile(path, 'w', zipfile.ZIP_STORED) as file:
        for name, chunk in _columns(ledger, reasons).items():
            pieces = (chunk(number) for number in range(plan.chunks))
            with _member(file, name) as out:
                _stream(out, plan.points, pieces)
        for name, value in (('reasons', np.array(reasons)), ('about', _line(plan))):
            with _member(file, name) as out:
                np.lib.format.write_array(out, np.asarray(value), allow_pickle=False)


def _member(file: zipfile.ZipFile, name: str) -> IO[bytes]:
    return file.open(zipfile.ZipInfo(f'{name}.npy', NEVER), 'w', force_zip64=True)


def _stream(out: IO[bytes], rows: int, pieces: Iterator[Column]) -> None:
    for number, piece in enumerate(pieces):
        if number == 0:
            descr = np.lib.format.dtype_to_descr(piece.dtype)
            header = {'descr': descr, 'fortran_order': False, 'shape': (rows,)}
            np.lib.format.write_array_header_1_0(out, header)
        out.write(np.ascontiguousarray(piece).data.cast('B'))


def _write_parquet(ledger: Ledger, reasons: list[str], path: Path) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    columns = _columns(ledger, reasons)
    described = about(ledger.plan)
    notes = {
        **described['varied'],
        **described['outputs'],
        'reason': {'unit': '', 'text': 'why it failed'},
    }

    def arrays(number: int) -> list[Any]:
        made = {name: chunk(number) for name, chunk in columns.items()}
        words = pa.DictionaryArray.from_arrays(made.pop('reason'), pa.array(reasons))
        return [*(pa.array(column) for column in made.values()), words]

    fields = [
        pa.field(name, array.type, metadata=notes[name])
        for name, array in zip(columns, arrays(0), strict=True)
    ]
    schema = pa.schema(fields, metadata={'qzs_rig': _line(ledger.plan)})
    group = max(1, GROUP // ledger.plan.chunk)
    with parquet.ParquetWriter(path, schema, compression='zstd') as writer:
        for start in range(0, ledger.plan.chunks, group):
            numbers = range(start, min(start + group, ledger.plan.chunks))
            made = [pa.Table.from_arrays(arrays(number), schema=schema) for number in numbers]
            writer.write_table(pa.concat_tables(made), row_group_size=2 * GROUP)


def _line(plan: Plan) -> str:
    return json.dumps(about(plan), allow_nan=False)
