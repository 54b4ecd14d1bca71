"""Records in .npz files: without pickle, with a checksum, replaced atomically."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import Advice, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._files import replacing, require_readable
from rcac_numeric.arrays._records import Records
from rcac_numeric.arrays._untrusted import (
    MOST_CHARACTERS,
    MOST_NUMBERS,
    names_in,
    parsed_json,
    read_npz,
)
from rcac_numeric.arrays._values import fingerprint
from rcac_numeric.arrays._wording import shortened

KEY = "rcac_record"
VERSION = 1


def write_record(path: str | Path, kind: str, parts: Mapping[str, Any], records: Records) -> None:
    """Write a record: arrays under their names, everything else as a tree.

    Functions are stored as a fingerprint only.
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
    _require_readable_again(path, kind, text, arrays)
    signed = json.dumps({"checksum": _checksum(text, arrays), "record": text})
    stored: dict[str, Any] = {KEY: np.array(signed), **arrays}
    with replacing(path) as file, file.open("wb") as stream:
        np.savez(stream, **stored)


def _require_readable_again(
    path: str | Path, kind: str, text: str, arrays: Mapping[str, Array]
) -> None:
    """Refuse to write a record that exceeds the limits of reading."""
    try:
        parsed_json(text)
    except ValueError as error:
        raise InputError(f"{path}: this {kind} would not be read again: {error}.") from None
    numbers = sum(part.nbytes // 8 for part in arrays.values())
    if numbers > MOST_NUMBERS or 2 * len(text) > MOST_CHARACTERS:
        raise InputError(
            f"{path}: this {kind} would not be read again: it holds {numbers} numbers and a text "
            f"of {len(text)} characters; {MOST_NUMBERS} and {MOST_CHARACTERS // 2} are read. Run "
            "it in pieces with start=, or keep theta less often with stride=."
        )


def is_record(path: str | Path) -> bool:
    """Whether a file is an archive with a record; its content is not read or checked."""
    try:
        require_readable(Path(path))
        return KEY in names_in(Path(path))
    except (InputError, OSError):
        return False


def read_record(
    path: str | Path, kind: str, records: Records, expected: Mapping[str, Any]
) -> dict[str, Any]:
    """Read the parts that `write_record` wrote; `expected` supplies the functions."""
    try:
        arrays = read_npz(Path(path))
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}.") from None
    except InputError as error:
        raise InputError(f"{path} holds no saved {kind}, or is damaged: {error}") from None
    try:
        signed = parsed_json(_text(arrays.pop(KEY)))
        text, checksum = signed["record"], signed["checksum"]
        if checksum != _checksum(text, arrays):
            raise _of(path, " is damaged: its checksum is not that of its contents.")
        whole = parsed_json(text)
        if (whole["kind"], whole["version"]) != (kind, VERSION):
            header = f"{whole['kind']!r:.60}, version {whole['version']!r:.20}"
            raise _of(path, f" holds {header}; a {kind}, version {VERSION}, is needed.")
        parts: dict[str, Any] = {
            name: _part(path, name, tree, records, arrays, expected)
            for name, tree in whole["parts"].items()
        }
    except InputError as error:
        raise (error if error.source else _of(path, ": ", *error.args)) from None
    except KeyError as error:
        raise InputError(f"{path} holds no saved {kind}: it has no {error}.") from None
    # The file may hold anything: the constructors of the packages refuse it with any error.
    except Exception as error:
        words = shortened(str(error) or type(error).__name__, 200)
        raise InputError(f"{path} holds no {kind} that this version can read: {words}.") from None
    used = {name for name in arrays if not name.startswith("part_")}
    return {**parts, **{name: arrays[name] for name in used}}


def _part(
    path: str | Path,
    name: str,
    tree: Mapping[str, Any],
    records: Records,
    arrays: Mapping[str, Array],
    expected: Mapping[str, Any],
) -> Any:
    if set(tree) == {"is"}:
        return records.value(tree["is"], arrays)
    if set(tree) != {"left out", "words"}:
        raise ValueError(f"its {name!r:.60} cannot be read")
    if expected.get(name) is None:
        words = f"{tree['words']!s:.200}"
        give_it = Advice("load_run", ((name, ""),), f"Give it with {name}=")
        raise _of(
            path, f": its {name} is made of functions, which a file cannot hold: {words}. ",
            give_it, "."
        )  # fmt: skip
    if fingerprint(expected[name]) != tree["left out"]:
        raise _of(path, f" was saved with another {name} than the one given.")
    return expected[name]


def _of(path: str | Path, *parts: str | Advice) -> InputError:
    """Return an error whose message begins with the file name."""
    return InputError(str(path), *parts).of(str(path))


def _text(array: Array) -> str:
    if array.ndim or array.dtype.kind != "U":
        raise ValueError("its record is no text")
    return str(array[()])


def _checksum(text: str, arrays: Mapping[str, Array]) -> str:
    digest = hashlib.sha256(text.encode())
    for name in sorted(arrays):
        part = arrays[name]
        digest.update(f"{name} {part.dtype.str} {part.shape}".encode())
        digest.update(np.ascontiguousarray(part).reshape(-1).view(np.uint8).data)
    return digest.hexdigest()
