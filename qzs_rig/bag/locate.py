"""Which file a path means (bag folder, run folder, the file), and the folder of a new bag."""

from __future__ import annotations

import re
from pathlib import Path

from qzs_rig.errors import BagError

SUFFIXES = ('.mcap', '.db3')
COMPRESSED = re.compile(r'^\s*compression_mode:\s*["\']?(file|message)\b', re.IGNORECASE | re.M)


def bag_file(path: Path) -> Path:
    """The one storage file at `path`; raises BagError naming what is there instead."""
    path = Path(path)
    if not path.exists():
        raise BagError(f'{path} does not exist; give a bag folder, a run folder or an .mcap file')
    if path.is_file():
        if path.suffix not in SUFFIXES:
            raise BagError(f'{path} is not a bag; give a bag folder, a run folder or an .mcap file')
        return path
    if (path / 'bag').is_dir() and not _storages(path):
        return bag_file(path / 'bag')
    _refuse_compressed(path)
    found = _storages(path)
    if not found:
        raise BagError(f'{path} holds no bag (no .mcap, no .db3); give the folder of a run')
    if len(found) > 1:
        names = ', '.join(file.name for file in found)
        raise BagError(f'{path} holds {len(found)} bags ({names}); give one of these files')
    return found[0]


def new_folder(folder: Path) -> Path:
    """`folder`, made where it is missing; raises BagError where something lies already."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        occupied = any(folder.iterdir())
    except OSError as error:
        raise BagError(
            f'bag folder {folder} cannot be made ({error.strerror}); choose another'
        ) from error
    if occupied:
        raise BagError(f'bag folder {folder} is not empty; choose a new one or move it away')
    return folder


def _storages(folder: Path) -> list[Path]:
    return sorted(file for file in folder.iterdir() if file.suffix in SUFFIXES)


def _refuse_compressed(folder: Path) -> None:
    """rosbag2 can compress whole files or single messages; MCAP compresses its chunks itself."""
    description = folder / 'metadata.yaml'
    if not description.is_file():
        return
    with description.open(encoding='utf-8', errors='replace') as text:
        mode = COMPRESSED.search(text.read(1 << 22))
    if mode:
        raise BagError(
            f'{folder} is compressed by {mode[1].lower()}, which only rosbag2 unpacks; '
            'convert it with `ros2 bag convert` to uncompressed MCAP'
        )
