"""One text for equal data, and a short name for the text."""

from __future__ import annotations

import hashlib
import inspect
import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._values import fingerprint, is_record

DATA_FILES = (".csv", ".npy", ".npz", ".mat", ".txt")


def canonical_json(value: Any) -> str:
    """Return one text for equal data, on every machine and for any order of keys.

    Keys are sorted, 1.0 is written 1, and a function counts by its name and its source.
    """
    return json.dumps(_merged(plain(value)), sort_keys=True, separators=(",", ":"))


def plain(value: Any) -> Any:
    """The data in the types of JSON, every number unchanged."""
    if value is None or isinstance(value, bool | str | int):
        return value
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float):
        if not math.isfinite(value):
            raise InputError(f"a study holds the number {value}; every number must be finite.")
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if callable(value):
        named = {"function": name_of(value), "source": source_of(value)}
        return named | ({"holds": fingerprint(value)} if is_record(value) else {})
    raise InputError(f"a study holds {value!r}, which is no number, text, list or table.")


def digest(text: str) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of a text."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def name_of(function: Callable[..., Any]) -> str:
    """Return the import path of a function, or of the class of a callable record: `module:name`."""
    function = type(function) if is_record(function) else function
    module = getattr(function, "__module__", "")
    name = getattr(function, "__qualname__", "")
    if not module or not name.isidentifier():
        raise InputError(
            f"{name or function!r} cannot be found again by another process: define the function "
            "with `def` at the top of a module."
        )
    return f"{module}:{name}"


def _merged(value: Any) -> Any:
    """Numbers that are equal are written alike."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 2**53:
        return int(value)
    if isinstance(value, dict):
        return {key: _merged(entry) for key, entry in value.items()}
    return [_merged(entry) for entry in value] if isinstance(value, list) else value


def data_files(value: Any) -> set[str]:
    """Every text in `value` that may be the name of a data file."""
    if isinstance(value, str):
        is_name = len(value) < 1000 and "\0" not in value
        return {value} if is_name and Path(value).suffix.lower() in DATA_FILES else set()
    if isinstance(value, Mapping | list | tuple):
        entries = value.values() if isinstance(value, Mapping) else value
        return set().union(*map(data_files, entries))
    return set()


def file_digests(value: Any, folder: str) -> dict[str, str]:
    """Every data file that a text in `value` names, with its digest."""
    files = {name: Path(folder) / name for name in sorted(data_files(value))}
    return {name: _digest_of_file(path) for name, path in files.items() if path.is_file()}


def _digest_of_file(path: Path) -> str:
    with path.open("rb") as stream:  # in blocks: a log may be larger than the memory
        return hashlib.file_digest(stream, "sha256").hexdigest()[:16]


def source_of(function: Callable[..., Any]) -> str:
    """The digest of the source of a function, or of a record's class; empty where there is none."""
    function = type(function) if is_record(function) else function
    try:
        return digest(inspect.getsource(function))
    except (OSError, TypeError):  # compiled, or typed in
        return ""
