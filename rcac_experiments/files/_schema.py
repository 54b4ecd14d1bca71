"""A JSON Schema of experiment files, for editors that complete and check TOML."""

from __future__ import annotations

from typing import Any

from rcac_experiments.experiments._true_systems import EXCITATION
from rcac_experiments.files._builder import FILE
from rcac_experiments.files._controllers import WITHOUT_TARGET
from rcac_experiments.files._estimation import ESTIMATION_FILE
from rcac_experiments.files._exact import EXACT_FILE
from rcac_experiments.files._runs import TABLES
from rcac_experiments.files._signals import SIGNAL
from rcac_experiments.format._tables import Kind, Kinds, Table
from rcac_experiments.format._values import Schema

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def json_schema() -> dict[str, Any]:
    """The schema of an experiment file, JSON Schema draft 2020-12.

    Whatever `load_experiment` accepts is valid. Where nothing is joined, that is without [[runs]]
    and [[controllers]], the schema says also which keys are needed and which do not go together;
    sizes, ranges that depend on each other, and mathematics are beyond it. A file without [run]
    is one for `rcac check`, which reads [plant], and as much of the rest as there is.

    Examples
    --------
    >>> from rcac_experiments import json_schema
    >>> schema = json_schema()
    >>> sorted(schema["properties"])[:3], schema["properties"]["run"]["properties"]["steps"]["type"]
    (['claims', 'controller', 'controllers'], 'integer')
    """
    schema = FILE.schema()
    others = [EXACT_FILE.schema(), ESTIMATION_FILE.schema()]
    parts = [dict(schema["properties"]), *(other["properties"] for other in others)]
    for part in parts[1:]:
        schema["properties"] = {**part, **schema["properties"]}
    for key in ("claims", "runs", "figures", "open"):
        schema["properties"][key] = {"anyOf": [part[key] for part in parts if key in part]}
    alone: Schema = {
        name: {"$ref": f"#/$defs/{name}"} for name in TABLES if name not in ("plant", "signals")
    }
    return {
        "$schema": DIALECT,
        "title": "Experiment of rcac",
        **schema,
        "anyOf": [
            {"required": ["plant"]},
            {"required": ["exact", "claims"]},
            {"required": ["estimation", "runs"]},
        ],
        "if": {
            "required": ["run"],
            "not": {"anyOf": [{"required": ["runs"]}, {"required": ["controllers"]}]},
        },
        "then": {
            "properties": alone,
            "required": ["controller"],
            "anyOf": [
                {"required": ["target"]},
                {"properties": {"controller": _named("structure", WITHOUT_TARGET)}},
            ],
        },
        "$defs": {
            SIGNAL.what.split()[-1]: SIGNAL.definition(),
            EXCITATION.what.split()[-1]: EXCITATION.definition(),
            **{name: strict_schema(TABLES[name].table) for name in alone},
        },
    }


# JSON Schemas that say of a table also which of its keys are needed and go together.


def strict_schema(table: Table[Any]) -> Schema:
    """The schema of a table that stands by itself, not joined with others.

    For every kind that is spread over the table it says which keys that kind needs, and that those
    of other kinds must not be there.
    """
    schema = table.schema()
    required = [
        key.name for key in table.keys if key.is_required and not isinstance(key.form, Kinds)
    ]
    required += [name for name, kinds in table.kinds.items() if kinds.default is None]
    whole = [
        _named(selector, name)
        for selector, kinds in table.kinds.items()
        for name, kind in kinds.kinds.items()
        if kind.is_whole
    ]
    conditions: list[Schema] = []
    if required and whole:
        conditions.append({"if": {"not": {"anyOf": whole}}, "then": {"required": required}})
    elif required:
        schema["required"] = required
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
    """Required and forbidden keys of a kind."""
    names_of_kind = set().union(*(variant.names for variant in kind.variants))
    if kind.is_whole:
        unread = set(table.all_keys()) - names_of_kind - {selector}
    else:
        others = {name for other in kinds.tables() for name in other.all_keys()}
        elsewhere = {key.name for key in table.keys}.union(
            *(t.all_keys() for s, k in table.kinds.items() if s != selector for t in k.tables())
        )
        unread = others - names_of_kind - elsewhere
    variants = []
    for variant in kind.variants:
        needed = [key.name for key in variant.table.keys if key.is_required]
        beside = dict.fromkeys(sorted(names_of_kind - variant.names), False)
        variants.append({"required": needed, "properties": beside})
    return {"properties": dict.fromkeys(sorted(unread), False), "anyOf": variants}
