"""The reference tables of docs/experiment-files.md, from the declarations of the format."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from rcac_experiments.experiments._figure_requests import FIGURE
from rcac_experiments.files._builder import FILE
from rcac_experiments.files._claims import CHECK, CLAIM
from rcac_experiments.files._controllers import CONTROLLER
from rcac_experiments.files._estimation import CHECK as ESTIMATION_CHECK
from rcac_experiments.files._estimation import ESTIMATOR, RUN, TRIAL
from rcac_experiments.files._plants import CHANGE, PLANT, PROBLEMS
from rcac_experiments.files._runs import OPEN_VALUE, OVERRIDE, RUN_OPTIONS, SATURATION
from rcac_experiments.files._signals import SIGNAL, SIGNALS
from rcac_experiments.files._structures import DERIVED
from rcac_experiments.files._targets import TARGETS
from rcac_experiments.files._updates import UPDATES
from rcac_experiments.format._tables import ByKey, Key, Kinds, Table
from rcac_experiments.judging._reading import open_table

PLACEHOLDERS = re.compile(r"<!-- table: (?P<name>[^\n]*?) -->")


def keys_table(table: Table[Any]) -> str:
    """One row for each key of a table: its meaning and its default.

    Examples
    --------
    >>> from rcac_numeric import Pulse
    >>> from rcac_experiments.files._reference import keys_table
    >>> from rcac_experiments.format._tables import Table
    >>> print(keys_table(Table(Pulse)))
    | key | meaning | default |
    |---|---|---|
    | `height` | Its value while it lasts. | 1 |
    | `start` | First step with that value. | 0 |
    | `length` | Number of steps with that value. | 1 |
    """
    beside = table.elsewhere[0].keys if table.elsewhere else ()
    return _rows([*table.keys, *beside])


def kinds_table(selector: str, kinds: Kinds[Any]) -> str:
    """One row for each kind: its meaning, required and optional keys."""
    rows = []
    for name, kind in kinds.kinds.items():
        for variant in kind.variants:
            default = " (the default)" if name == kinds.default else ""
            keys = ", ".join(map(_optional, variant.table.keys))
            rows.append(f'| `"{name}"`{default} | {cell(variant.table.summary)} | {keys} |')
    return "\n".join([f"| `{selector}` | what it is | its keys |", "|---|---|---|", *rows])


def kind_keys_table(kinds: Kinds[Any]) -> str:
    """One row for each key that kinds read, described where it is described first."""
    keys: dict[str, list[Key]] = {}
    for table in kinds.tables():
        for key in table.keys:
            keys.setdefault(key.name, []).append(key)
    return _rows([next((k for k in keys if k.doc), keys[0]) for keys in keys.values()])


def by_key_table(by_key: ByKey[Any]) -> str:
    """One row for each kind that a key names."""
    rows = []
    for name, table in by_key.kinds.items():
        first, *others = table.keys
        keys = "; ".join(map(_short_type, others))
        rows.append(f"| `{name}` | {cell(table.summary)} | {cell(first.doc)} | {cell(keys)} |")
    head = ["| key | what it is | its value | other keys |", "|---|---|---|---|"]
    return "\n".join([*head, *rows])


def with_tables(page: str, tables: Mapping[str, str]) -> str:
    r"""A page with a table in place of each placeholder `<!-- table: NAME -->`.

    Examples
    --------
    >>> from rcac_experiments.files._reference import with_tables
    >>> print(with_tables("<!-- table: a -->", {"a": "| key |"}))
    | key |
    """
    return PLACEHOLDERS.sub(lambda match: tables[match["name"]], page)


def cell(text: str) -> str:
    """A text as the cell of a table."""
    return re.sub(r"\s+", " ", text).replace("|", "\\|")


def _rows(keys: list[Key]) -> str:
    """A row for each key; neighbours that are described together share one."""
    rows: list[tuple[list[str], str, str]] = []
    for key in keys:
        meaning, default = cell(key.doc), _default(key)
        if rows and rows[-1][1:] == (meaning, default):
            rows[-1][0].append(f"`{key.name}`")
        else:
            rows.append(([f"`{key.name}`"], meaning, default))
    lines = [f"| {', '.join(names)} | {meaning} | {default} |" for names, meaning, default in rows]
    return "\n".join(["| key | meaning | default |", "|---|---|---|", *lines])


def _default(key: Key) -> str:
    if isinstance(key.form, Kinds):
        return f'`"{key.form.default}"`' if key.form.default else "needed"
    if key.is_required:
        return "needed"
    if key.default is None or key.default in ("", (), [], {}):
        return ""
    if isinstance(key.default, bool):
        return f"`{str(key.default).lower()}`"
    return f'`"{key.default}"`' if isinstance(key.default, str) else f"{key.default:g}"


def _optional(key: Key) -> str:
    return f"`{key.name}`" if key.is_required else f"[`{key.name}`]"


def _short_type(key: Key) -> str:
    default = _default(key)
    shown = f" ({default})" if default not in ("", "needed") else ""
    return f"`{key.name}`{shown}: {key.doc.removesuffix('.')}"


def reference_tables() -> dict[str, str]:
    """Every generated table by its name in the page."""
    structures = CONTROLLER.table.kinds["structure"]
    measures = CHECK.kinds["measure"]
    tables = {
        "file": keys_table(FILE),
        "plant": keys_table(PLANT.table),
        "plant.changes": keys_table(CHANGE),
        "signals": keys_table(SIGNALS),
        "a signal": by_key_table(SIGNAL),
        "controller": keys_table(CONTROLLER.table),
        "controller.derived": keys_table(DERIVED),
        "saturation": keys_table(SATURATION.table),
        "run": keys_table(RUN_OPTIONS.table),
        "runs": keys_table(OVERRIDE),
        "claims": keys_table(CLAIM),
        "claims.checks": keys_table(CHECK),
        "open": keys_table(open_table(OPEN_VALUE)),
        "figures": keys_table(FIGURE),
    }
    spread: dict[str, tuple[str, Kinds[Any]]] = {
        "problems": ("problem", PROBLEMS),
        "models": ("model", TARGETS),
        "structures": ("structure", structures),
        "updates": ("update", UPDATES),
        "measures": ("measure", measures),
    }
    for name, (selector, kinds) in spread.items():
        tables[name] = kinds_table(selector, kinds)
        tables[f"keys of {name}"] = kind_keys_table(kinds)
    tables["estimation"] = keys_table(TRIAL.table)
    tables["estimation runs"] = keys_table(RUN)
    tables["estimation measures"] = kinds_table("measure", ESTIMATION_CHECK.kinds["measure"])
    for name, kind in ESTIMATOR.table.kinds["kind"].kinds.items():
        if name != "ukf":
            tables[f"estimator {name}"] = keys_table(kind.variants[0].table)
    for key in UPDATES.kinds["ud"].variants[0].table.keys:
        if isinstance(key.form, Table):
            tables[f"controller.{key.name}"] = keys_table(key.form)
    return tables


def page_with_tables(page: str) -> str:
    """The page docs/experiment-files.md with its tables filled in."""
    return with_tables(page, reference_tables())
