"""Tables of documentation in Markdown, from the same declarations that files are read by."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from rcac_numeric.experiments.format.tables import ByKey, Key, Kinds, Table

MARKERS = re.compile(r"(<!-- table: (?P<name>[^\n]*?) -->\n).*?(\n<!-- end of table -->)", re.S)


def keys_table(table: Table[Any]) -> str:
    """One row for each key of a table itself: what it means and what it defaults to.

    Examples
    --------
    >>> from rcac_numeric import Pulse
    >>> from rcac_numeric.experiments.format.markdown import keys_table
    >>> from rcac_numeric.experiments.format.tables import Table
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
    """One row for each kind: what it is, and the keys that it needs and may have."""
    rows = []
    for name, kind in kinds.kinds.items():
        for variant in kind.variants:
            default = " (the default)" if name == kinds.default else ""
            keys = ", ".join(map(_optional, variant.table.keys))
            rows.append(f'| `"{name}"`{default} | {cell(variant.table.summary)} | {keys} |')
    return "\n".join([f"| `{selector}` | what it is | its keys |", "|---|---|---|", *rows])


def kind_keys_table(kinds: Kinds[Any]) -> str:
    """One row for each key that kinds read, described where it is described first."""
    found: dict[str, list[Key]] = {}
    for table in kinds.tables():
        for key in table.keys:
            found.setdefault(key.name, []).append(key)
    return _rows([next((k for k in keys if k.doc), keys[0]) for keys in found.values()])


def by_key_table(what: ByKey[Any]) -> str:
    """One row for each kind that a key names."""
    rows = []
    for name, table in what.kinds.items():
        first, *others = table.keys
        keys = "; ".join(map(_brief, others))
        rows.append(f"| `{name}` | {cell(table.summary)} | {cell(first.doc)} | {cell(keys)} |")
    head = ["| key | what it is | its value | other keys |", "|---|---|---|---|"]
    return "\n".join([*head, *rows])


def with_tables(page: str, tables: Mapping[str, str]) -> str:
    r"""A page with its generated tables brought up to date.

    They stand between `<!-- table: NAME -->` and `<!-- end of table -->`.

    Examples
    --------
    >>> from rcac_numeric.experiments.format.markdown import with_tables
    >>> print(with_tables("<!-- table: a -->\nold\n<!-- end of table -->", {"a": "new"}))
    <!-- table: a -->
    new
    <!-- end of table -->
    """
    return MARKERS.sub(lambda match: match[1] + tables[match["name"]] + match[3], page)


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


def _brief(key: Key) -> str:
    default = _default(key)
    shown = f" ({default})" if default not in ("", "needed") else ""
    return f"`{key.name}`{shown}: {key.doc.removesuffix('.')}"
