"""The explorer in a notebook, or wherever else HTML is displayed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from compensator_theory.errors import InputError
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_experiments.explorer._case import case_of
from rcac_experiments.explorer._page import explorer_page
from rcac_experiments.files._documents import read_file
from rcac_numeric.arrays._values import Result
from rcac_numeric.reports._rendering import write_page

FRAME = "width: 100%; height: 60rem; border: 0"


@dataclass(frozen=True)
class ExplorerPage(Result):
    """An interactive page on which an RCAC loop runs; a notebook displays it, and it works offline.

    Attributes
    ----------
    title : str
        Title of the first case of the page.
    text : str
        The HTML of the page.
    """

    title: str
    text: str

    def save(self, path: str | Path) -> None:
        """Write the page as one HTML file."""
        write_page(self.text, path)

    def __repr__(self) -> str:
        return f"ExplorerPage({self.title!r}, {len(self.text)} bytes)"

    def _repr_html_(self) -> str:
        """The page for a notebook, in a separate frame that may run only its script."""
        return (
            f'<iframe srcdoc="{escape(self.text)}" title="The RCAC explorer" '
            f'sandbox="allow-scripts" style="{FRAME}"></iframe>'
        )


def explore(
    case: str | Path | Mapping[str, Any] | None = None,
    *,
    run: str | None = None,
    budget: ExperimentBudget | None = None,
) -> ExplorerPage:
    """Make an interactive page of a case: drag poles, move dials, and the loop runs again.

    Parameters
    ----------
    case : path or mapping, optional
        An experiment file, or its tables; by default the page has only its built-in scenes.
    run : str, optional
        Name of the run of the case; the first by default.
    budget : ExperimentBudget, optional
        Limits for the case; `ExperimentBudget()` by default.

    Returns
    -------
    ExplorerPage
        A notebook shows it; `save` writes it as a file, as `rcac explore` does.

    Raises
    ------
    InputError
        If the case cannot be read, or if it has settings for which the page has no dial.

    Examples
    --------
    >>> from rcac_experiments import explore
    >>> explore({"plant": {"problem": "standard", "G": "1/(q - 0.5)"}, "controller": {}})
    Traceback (most recent call last):
        ...
    compensator_theory.errors.InputError: the case: ...
    """
    if case is None:
        if run is not None:
            raise InputError(f"run = {run!r} belongs to a case; give one.")
        return ExplorerPage("built-in scenes", explorer_page())
    table, file = (dict(case), "the case") if isinstance(case, Mapping) else read_file(case)
    dials = case_of(table, file, run, budget)
    return ExplorerPage(str(dials["title"]), explorer_page(dials))
