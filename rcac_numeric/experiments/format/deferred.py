"""Tables that are joined with others before they are read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rcac_numeric.experiments.format.places import Place
from rcac_numeric.experiments.format.tables import Raw, Table, require_table
from rcac_numeric.experiments.format.values import Form, Schema


@dataclass(frozen=True)
class Deferred(Form):
    """A table that is read once it is joined with others; until then only its keys are looked at.

    Attributes
    ----------
    table : Table
    is_replaced : bool
        Whether a table that names a kind replaces the one before it as a whole.
    """

    table: Table[Any]
    is_replaced: bool = False

    @property
    def words(self) -> str:
        """Those of the table."""
        return self.table.words

    def read(self, value: object, place: Place) -> dict[str, Any]:
        """As it stands."""
        inside = place.inside()
        found = dict(require_table(value, inside))
        self.table.require_known(found, inside)
        return found

    def schema(self) -> Schema:
        """That of the table."""
        return self.table.schema()

    def joined(self, base: Raw, override: Raw) -> dict[str, Any]:
        """`base` with the entries of `override`, inner tables joined likewise.

        Where `override` names another kind, keys that only the old kind reads are left out: they
        would mean nothing to the new one.
        """
        kept = dict(base)
        for selector, kinds in self.table.kinds.items():
            kind = kinds.kinds.get(str(override.get(selector)))
            if kind is None or override[selector] == base.get(selector, kinds.default):
                if selector in override and self.is_replaced:
                    kept = {}
                continue
            read = {name for variant in kind.variants for name in variant.names}
            own = {key.name for key in self.table.keys}
            kept = {
                name: value
                for name, value in kept.items()
                if not self.is_replaced
                and (name in read or not (kind.is_whole or (kinds.has(name) and name not in own)))
            }
        return merged(kept, override)


def merged(base: Mapping[str, Any], override: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the entries of `override`, table by table.

    Examples
    --------
    >>> from rcac_numeric.experiments.format.deferred import merged
    >>> merged({"a": {"b": 1, "c": 2}, "d": 3}, {"a": {"c": 4}})
    {'a': {'b': 1, 'c': 4}, 'd': 3}
    """
    result = dict(base)
    for key, value in override.items():
        old = result.get(key)
        is_joined = isinstance(old, Mapping) and isinstance(value, Mapping)
        result[key] = merged(old, value) if is_joined else value  # type: ignore[arg-type]
    return result
