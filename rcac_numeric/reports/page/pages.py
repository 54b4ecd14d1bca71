"""The page of a case of one's own, a whole HTML document."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

from rcac_numeric.arrays.wording import in_a_line
from rcac_numeric.reports.page.cases import Case
from rcac_numeric.reports.page.rendering import HOME, whole_page

NAMED = ("compensator-theory", "numpy", "scipy", "sympy", "python-flint", "matplotlib")


def case_page(case: Case, *, template: str = "case.html", home: str = HOME, **more: Any) -> str:
    """The page of one case.

    Parameters
    ----------
    case : Case
    template, home : str
        A template that extends ``case.html``, and the package whose it is.
    **more
        What that template says besides.
    """
    title = in_a_line(f"{case.id}: {case.title}".strip(": "))
    lead = case.source or "A case, its claims and what was measured."
    told: dict[str, Any] = {"title": title, "lead": lead, "case": case, "made": made_with([case])}
    return whole_page(template, home, **told, **more)


def made_with(cases: Sequence[Case]) -> dict[str, Any]:
    """Versions, machine and seeds: what else decides the numbers of a page."""
    machine = f"Python {platform.python_version()}, {platform.system()} on {platform.machine()}"
    versions = [f"{name} {version(name)}" for name in NAMED]
    return {"versions": versions, "machine": machine, "cases": cases}
