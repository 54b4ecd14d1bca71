"""How a result shows itself without importing what shows it."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from compensator_theory import figures

# Pictures and reports stand above every result and import it. A result asks their table, which is
# imported when the first result is shown: the one import that goes upwards, and by name.
TABLE = "rcac_numeric.reports._displays"


def picture_of(result: object, *arguments: Any, **options: Any) -> figures.Figure:
    """The picture of a result."""
    drawn: figures.Figure = import_module(TABLE).picture_of(result, *arguments, **options)
    return drawn


def sheet_of(result: object) -> Any:
    """The report of a result as data."""
    return import_module(TABLE).sheet_of(result)


def report_of(result: object) -> str:
    """The report of a result in words and numbers."""
    return str(import_module(TABLE).report_of(result))


def notebook_of(result: object, draw: Callable[[], figures.Figure] | None = None) -> str:
    """What a notebook shows of a result: its report and, where it has one, its picture."""
    return str(import_module(TABLE).notebook_of(result, draw))
