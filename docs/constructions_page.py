"""The table of named constructions as a page shows it, from docs/constructions.toml."""

import tomllib
from pathlib import Path
from typing import Any

FILE = Path(__file__).resolve().parent / "constructions.toml"


def constructions() -> list[dict[str, Any]]:
    """Every named construction: number, name, functions, oracle, test and peers."""
    return tomllib.loads(FILE.read_text())["construction"]


def constructions_table() -> str:
    """All constructions as a table of Markdown, with links to their functions."""
    head = "| # | construction | function | oracle of its test | who |\n|---|---|---|---|---|"
    return "\n".join([head, *(_row(construction) for construction in constructions())])


def _row(construction: dict[str, Any]) -> str:
    functions = ", ".join(_link(path) for path in construction["functions"])
    return (
        f"| {construction['number']} | {construction['name']} | {functions} | "
        f"{construction['oracle']}: `{construction['test']}` | {construction['peers']} |"
    )


def _link(path: str) -> str:
    name = path.rpartition(".")[2]
    return f"{{py:{'class' if name[0].isupper() else 'func'}}}`{name} <{path}>`"
