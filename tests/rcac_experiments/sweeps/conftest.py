"""Chunks are read in this process: a child of its own for every table would take minutes."""

import pytest

from rcac_experiments.sweeps import _folder, _reader


@pytest.fixture(autouse=True)
def in_this_process(request, monkeypatch):
    """But where a test asks for the child; tests/fuzz/test_folders.py reads all in it."""
    if request.node.get_closest_marker("guarded") is None:
        monkeypatch.setattr(_folder, "read_guarded", _reader.read_in_process)
