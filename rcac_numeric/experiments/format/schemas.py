"""JSON Schemas that say of a table also which of its keys are needed and go together."""

from __future__ import annotations

from typing import Any

from rcac_numeric.experiments.format.tables import Kind, Kinds, Table
from rcac_numeric.experiments.format.values import Schema


def strict_schema(table: Table[Any]) -> Schema:
    """The schema of a table that stands by itself, not joined with others.

    For every kind that is spread over the table it says which keys that kind needs, and that those
    of other kinds must not be there.

    Examples
    --------
    >>> from rcac_numeric import pid, fir
    >>> from rcac_numeric.experiments.format.schemas import strict_schema
    >>> from rcac_numeric.experiments.format.tables import Kinds, Table
    >>> given = ["l_u", "l_y"]
    >>> strict_schema(Table(fir, given=given))["required"]
    ['n_c']
    """
    schema = table.schema()
    own = [key.name for key in table.keys if key.is_required and not isinstance(key.form, Kinds)]
    own += [name for name, kinds in table.kinds.items() if kinds.default is None]
    whole = [
        _named(selector, name)
        for selector, kinds in table.kinds.items()
        for name, kind in kinds.kinds.items()
        if kind.is_whole
    ]
    conditions: list[Schema] = []
    if own and whole:
        conditions.append({"if": {"not": {"anyOf": whole}}, "then": {"required": own}})
    elif own:
        schema["required"] = own
    for selector, kinds in table.kinds.items():
        for name, kind in kinds.kinds.items():
            chosen = _named(selector, name, is_default=name == kinds.default)
            if whole and not kind.is_whole:
                chosen = {"allOf": [chosen, {"not": {"anyOf": whole}}]}
            conditions.append({"if": chosen, "then": _then(table, selector, kinds, kind)})
    return {**schema, **({"allOf": conditions} if conditions else {})}


def _named(selector: str, name: str, is_default: bool = False) -> Schema:
    """That a table names this kind, or none where it is the default."""
    schema: Schema = {"properties": {selector: {"const": name}}}
    return schema if is_default else {**schema, "required": [selector]}


def _then(table: Table[Any], selector: str, kinds: Kinds[Any], kind: Kind[Any]) -> Schema:
    """What must and what must not stand beside the name of a kind."""
    own = set().union(*(variant.names for variant in kind.variants))
    if kind.is_whole:
        unread = set(table.all_keys()) - own - {selector}
    else:
        others = {name for other in kinds.tables() for name in other.all_keys()}
        elsewhere = {key.name for key in table.keys}.union(
            *(t.all_keys() for s, k in table.kinds.items() if s != selector for t in k.tables())
        )
        unread = others - own - elsewhere
    variants = []
    for variant in kind.variants:
        needed = [key.name for key in variant.table.keys if key.is_required]
        beside = dict.fromkeys(sorted(own - variant.names), False)
        variants.append({"required": needed, "properties": beside})
    return {"properties": dict.fromkeys(sorted(unread), False), "anyOf": variants}
