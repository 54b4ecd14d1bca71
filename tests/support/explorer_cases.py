"""A case of one's own for the explorer, and what building its page needs."""

import shutil
import tomllib

import pytest

needs_clang = pytest.mark.skipif(
    shutil.which("clang") is None or shutil.which("wasm-ld") is None,
    reason="clang and wasm-ld are not installed",
)
CASE = """
id = "own"
title = "</script><b>Mine</b>"
[plant]
problem = "standard"
G = "(q - 0.3)/((q - 0.9)*(3*q - 1))"
[signals]
w = { sum = [{ step = 1 }, { white_noise = 0.5 }] }
[target]
model = "pole placement"
poles = ["0.5", "0.5", "0.2+0.4j", "0.2-0.4j"]
H = "1/2"
[controller]
n_c = 2
k_w = 7
R_theta = 0.25
lambda = 0.999
[run]
steps = 90
seed = 11
"""


def own(**changes):
    """The tables, with other entries; None takes one away, and a table in a list is a new one."""
    tables = tomllib.loads(CASE)
    for name, entries in changes.items():
        (old, new) = ({}, entries[0]) if isinstance(entries, list) else (tables.get(name), entries)
        joined = {**(old or {}), **new}
        tables[name] = {key: value for key, value in joined.items() if value is not None}
    return tables
