"""Records in .npz files: no pickle, a checksum, and replaced as a whole or not at all."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.files import replacing
from rcac_numeric.arrays.records import Records
from rcac_numeric.arrays.values import fingerprint

KEY = "rcac_record"
VERSION = 1


def write_record(path: str | Path, kind: str, parts: Mapping[str, Any], records: Records) -> None:
    """Write parts by name: arrays under their own names, and everything else as a tree.

    A part that is made of functions is kept by its fingerprint alone.

    Raises
    ------
    InputError
        Where the file cannot be written, or its name does not end in .npz.
    """
    if Path(path).suffix.lower() != ".npz":
        raise InputError(f"{path}: the name of a saved {kind} must end in .npz.")
    arrays = {name: part for name, part in parts.items() if isinstance(part, np.ndarray)}
    tree: dict[str, Any] = {}
    for name, part in parts.items():
        if name not in arrays:
            try:
                tree[name] = {"is": records.tree(part, arrays)}
            except InputError:
                tree[name] = {"left out": fingerprint(part), "words": repr(part)[:200]}
    arrays = {name: np.ascontiguousarray(part) for name, part in arrays.items()}
    text = json.dumps({"kind": kind, "version": VERSION, "parts": tree})
    signed = json.dumps({"checksum": _checksum(text, arrays), "record": text})
    stored: dict[str, Any] = {KEY: np.array(signed), **arrays}
    with replacing(path) as file, file.open("wb") as stream:
        np.savez(stream, **stored)


def is_record(path: str | Path) -> bool:
    """Whether a file is one that `write_record` wrote, damaged or not."""
    try:
        with Path(path).open("rb") as file, np.load(file, allow_pickle=False) as data:
            return KEY in data.files
    except Exception:  # zipfile, zlib and NumPy each have their own
        return False


def read_record(
    path: str | Path, kind: str, records: Records, given: Mapping[str, Any]
) -> dict[str, Any]:
    """The parts that `write_record` wrote; those in `given` stand for what was left out.

    Raises
    ------
    InputError
        Where the file cannot be read, is damaged or of another kind, or a part was left out and is
        not given, or is given and another one.
    """
    try:
        with Path(path).open("rb") as file, np.load(file, allow_pickle=False) as data:
            signed = json.loads(str(data[KEY][()]))
            arrays = {name: data[name] for name in data.files if name != KEY}
        text, checksum = signed["record"], signed["checksum"]
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}.") from None
    except Exception as error:  # zipfile, zlib and NumPy each have their own
        raise InputError(f"{path} holds no saved {kind}, or is damaged: {error}.") from None
    if checksum != _checksum(text, arrays):
        raise InputError(f"{path} is damaged: its checksum is not that of its contents.")
    try:
        whole = json.loads(text)
        if whole["kind"] != kind or whole["version"] != VERSION:
            raise InputError(
                f"{path} holds a {whole['kind']}, version {whole['version']}; a {kind}, version "
                f"{VERSION}, is needed."
            )
        parts: dict[str, Any] = {
            name: _part(path, name, tree, records, arrays, given)
            for name, tree in whole["parts"].items()
        }
    except (LookupError, TypeError, ValueError) as error:
        raise InputError(f"{path} holds no {kind} that this version can read: {error}.") from None
    used = {name for name in arrays if not name.startswith("part_")}
    return {**parts, **{name: arrays[name] for name in used}}


def _part(
    path: str | Path,
    name: str,
    tree: Mapping[str, Any],
    records: Records,
    arrays: Mapping[str, Array],
    given: Mapping[str, Any],
) -> Any:
    if "is" in tree:
        return records.value(tree["is"], arrays)
    if given.get(name) is None:
        raise InputError(
            f"{path}: its {name} is made of functions, which a file cannot hold: {tree['words']}. "
            f"Give it with {name}=."
        )
    if fingerprint(given[name]) != tree["left out"]:
        raise InputError(f"{path} was saved with another {name} than the one given.")
    return given[name]


def _checksum(text: str, arrays: Mapping[str, Array]) -> str:
    digest = hashlib.sha256(text.encode())
    for name in sorted(arrays):
        part = arrays[name]
        digest.update(f"{name} {part.dtype.str} {part.shape}".encode())
        digest.update(np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()
