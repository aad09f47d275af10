from __future__ import annotations

from pathlib import Path

import pytest
from bag_samples import record


@pytest.fixture(scope='session')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A closed bag of 1000 samples; not to be changed."""
    return record(tmp_path_factory.mktemp('run') / 'bag')


@pytest.fixture(scope='session')
def unfinished(bag: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same file as a kill leaves it: without summary and footer."""
    from mcap.reader import make_reader

    data = (bag / 'bag_0.mcap').read_bytes()
    with (bag / 'bag_0.mcap').open('rb') as file:
        last = make_reader(file).get_summary().chunk_indexes[-1]
    path = tmp_path_factory.mktemp('killed') / 'killed_0.mcap'
    end = last.chunk_start_offset + last.chunk_length + last.message_index_length
    path.write_bytes(data[:end])
    return path
