"""A JSON Schema of experiment files, for editors that complete and check TOML."""

from __future__ import annotations

from typing import Any

from rcac_numeric.experiments.estimation_files.reading import ESTIMATION_FILE
from rcac_numeric.experiments.estimation_files.tables import EXCITATION
from rcac_numeric.experiments.exact_files.reading import EXACT_FILE
from rcac_numeric.experiments.files.builder import FILE
from rcac_numeric.experiments.files.runs import TABLES
from rcac_numeric.experiments.files.signals import SIGNAL
from rcac_numeric.experiments.format.schemas import strict_schema
from rcac_numeric.experiments.format.values import Schema

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def json_schema() -> dict[str, Any]:
    """The schema of an experiment file, JSON Schema draft 2020-12.

    Whatever `load_experiment` accepts is valid. Where nothing is joined, that is without [[runs]]
    and [[controllers]], the schema says also which keys are needed and which do not go together;
    sizes, ranges that depend on each other, and mathematics are beyond it. A file without [run]
    is one for `rcac check`, which reads [plant], and as much of the rest as there is.

    Examples
    --------
    >>> from rcac_numeric import json_schema
    >>> schema = json_schema()
    >>> sorted(schema["properties"])[:3], schema["properties"]["run"]["properties"]["steps"]["type"]
    (['claims', 'controller', 'controllers'], 'integer')
    """
    schema = FILE.schema()
    others = [EXACT_FILE.schema(), ESTIMATION_FILE.schema()]
    parts = [dict(schema["properties"]), *(other["properties"] for other in others)]
    for part in parts[1:]:
        schema["properties"] = {**part, **schema["properties"]}
    for key in ("claims", "runs", "figures"):
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
        "then": {"properties": alone, "required": ["target", "controller"]},
        "$defs": {
            SIGNAL.what.split()[-1]: SIGNAL.definition(),
            EXCITATION.what.split()[-1]: EXCITATION.definition(),
            **{name: strict_schema(TABLES[name].table) for name in alone},
        },
    }
