"""Places in a document by dotted path, such as plant.changes.0.delay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.experiments.format.places import did_you_mean


def with_value(document: Mapping[str, Any], path: str, value: Any) -> dict[str, Any]:
    """The document with one value set; what is around it is copied, nothing changed.

    The table around it must be there; the last key may be new, an entry of a list may not.
    """
    keys = path.split(".")
    changed = _with(document, keys, value, path, "")
    assert isinstance(changed, dict)
    return changed


def _with(around: Any, keys: list[str], value: Any, path: str, walked: str) -> Any:
    key, rest = keys[0], keys[1:]
    here = f"{walked}.{key}" if walked else key
    if isinstance(around, list):
        if not key.isdecimal() or int(key) >= len(around):
            raise InputError(
                f"{path!r} leads nowhere: {walked} is a list of {len(around)}, and {key!r} is not "
                f"the number of one of its entries, from 0 on."
            )
        copy: Any = list(around)
        copy[int(key)] = _with(around[int(key)], rest, value, path, here) if rest else value
        return copy
    if not isinstance(around, Mapping):
        raise InputError(f"{path!r} leads nowhere: {walked} is {around!r}, which has no entries.")
    if not key or (rest and key not in around) or (not rest and not walked):
        raise InputError(
            f"{path!r} leads nowhere: {walked or 'the file'} has {', '.join(around)}."
            f"{did_you_mean(key, around)}"
        )
    return {**around, key: _with(around[key], rest, value, path, here) if rest else value}
