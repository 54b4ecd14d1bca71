"""The table of what shows each type of result: its picture, its report, its display in a notebook.

`rcac_numeric.arrays.showing` is how a result asks it. A type and what shows it are named, and
imported when they are needed: a report needs no Matplotlib, and the picture of a run no studies.
A type that is derived from one of these is shown like it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from itertools import count
from pkgutil import resolve_name
from typing import Any

from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_numeric.arrays.wording import in_a_line
from rcac_numeric.reports.rendering import sheet_html, words
from rcac_numeric.reports.sheet import Sheet
from rcac_numeric.reports.svg import svg_of
from rcac_numeric.reports.terminal import as_text

# From a type to the function that draws it.
PICTURES = {
    "compensator_theory.stability.margins:StabilityMargins": (
        "rcac_numeric.plots.margins:plot_stability_margins"
    ),
    "compensator_theory.stability.root_locus:RootLocus": (
        "rcac_numeric.plots.root_locus:plot_root_locus"
    ),
    "rcac_numeric.analysis.exact_comparison:ExactComparison": (
        "rcac_numeric.plots.run:plot_comparison"
    ),
    "rcac_numeric.analysis.loop_analysis:LoopAnalysis": "rcac_numeric.plots.run:plot_sheet",
    "rcac_numeric.analysis.match:IntercalatedMatch": "rcac_numeric.plots.run:plot_match",
    "rcac_numeric.analysis.observer_forms:NumericObserverForms": (
        "rcac_numeric.plots.observer_forms:plot_observer_forms"
    ),
    "rcac_numeric.checks.check:ControllerCheck": "rcac_numeric.plots.check:plot_check",
    "rcac_numeric.engine.runs:Run": "rcac_numeric.plots.runs:plot_run",
    "rcac_numeric.estimation.estimates:ModeEstimates": (
        "rcac_numeric.plots.modes:plot_modes"
    ),
    "rcac_numeric.analysis.lqg:LQG": "rcac_numeric.plots.lqg:plot_lqg",
    "rcac_numeric.analysis.classical:Margins": "rcac_numeric.plots.margins:plot_margins",
    "rcac_numeric.analysis.disk:DiskMargin": "rcac_numeric.plots.margins:plot_disk_margin",
    "rcac_numeric.plants.gallery.continuous:ContinuousPlant": (
        "rcac_numeric.plots.plants:plot_continuous_plant"
    ),
    "rcac_numeric.plants.gallery.zeros:ZeroPath": (
        "rcac_numeric.plots.plants:plot_zero_path"
    ),
    "rcac_numeric.designing.design:Design": "rcac_numeric.plots.design:plot_design",
}

# From a type to the function that writes its report.
SHEETS = {
    "rcac_numeric.analysis.exact_comparison:ExactComparison": (
        "rcac_numeric.reports.loop:comparison_sheet"
    ),
    "rcac_numeric.analysis.loop_analysis:LoopAnalysis": "rcac_numeric.reports.loop:analysis_sheet",
    "rcac_numeric.checks.check:ControllerCheck": "rcac_numeric.reports.check:check_sheet",
    "rcac_numeric.engine.runs:Run": "rcac_numeric.reports.loop:run_sheet",
    "rcac_numeric.analysis.lqg:LQG": "rcac_numeric.reports.lqg:lqg_sheet",
    "rcac_numeric.checks.health:LoopHealth": "rcac_numeric.reports.loop:health_sheet",
    "rcac_numeric.analysis.classical:Margins": "rcac_numeric.reports.check:margins_sheet",
    "rcac_numeric.designing.design:Design": "rcac_numeric.reports.design:design_sheet",
}

# From a type to the function that draws it as several small pictures for a page.
SMALL_PICTURES: dict[str, str] = {}


def picture_of(result: object, *arguments: Any, **options: Any) -> figures.Figure:
    """The picture of a result."""
    drawn: figures.Figure = _shows("PICTURES", result)(result, *arguments, **options)
    return drawn


def small_pictures_of(result: object) -> dict[str, figures.Figure]:
    """The pictures of a result for a page that is read on a phone, by what they show."""
    return dict(_shows("SMALL_PICTURES", result)(result))


def sheet_of(result: object) -> Sheet:
    """The report of a result as data."""
    sheet: Sheet = _shows("SHEETS", result)(result)
    return sheet


def report_of(result: object) -> str:
    """The report of a result as plain text."""
    return as_text(sheet_of(result))


def notebook_of(result: object, draw: Callable[[], figures.Figure] | None = None) -> str:
    """The report of a result as HTML and, where it is drawn, its picture below."""
    return notebook_html(sheet_of(result), draw)


def _shows(table: str, result: object) -> Any:
    """What shows a result; that of a base class where its own has none."""
    for kind in type(result).__mro__:
        # A package that has results of its own names its table, and is imported where they are.
        package = sys.modules.get(kind.__module__.partition(".")[0])
        for home in (__name__, getattr(package, "DISPLAYS", __name__)):
            shown = getattr(import_module(home), table).get(
                f"{kind.__module__}:{kind.__qualname__}"
            )
            if shown is not None:
                return resolve_name(shown)
    raise InputError(f"a {type(result).__name__} cannot be shown in this way.")


# What a notebook shows of a result: its report and its picture, on paper of any colour.

# The notebook's own ink, and colours that stand out from white and from black by 3 to 1.
STYLE = """.rcac { --ink: currentColor; --quiet: #808790; --line: #80879066; --good: #2b8a3e;
--warning: #b26a00; --bad: #d6455d; --c1: #2f7fc1; --c2: #d6553f; --c3: #2a9080; --c4: #bf7215;
--c5: #9068c9; --c6: #a0705f; --c7: #c2559f; --c8: #858600; --c9: #1f8d9c; }
.rcac svg { max-width: 46rem; width: 100%; height: auto; } .rcac svg text { fill: currentColor; }
.rcac .good { color: var(--good); } .rcac .warning { color: var(--warning); }
.rcac .bad { color: var(--bad); } .rcac .quiet, .rcac dt { color: var(--quiet); }
.rcac svg * { stroke-linejoin: round; stroke-linecap: butt; }"""
_numbers = count()


def notebook_html(sheet: Sheet, draw: Callable[[], figures.Figure] | None = None) -> str:
    """A report in the ink of the notebook that it stands in, and a picture below it.

    Without Matplotlib it is the report alone.
    """
    title = words(in_a_line(sheet.title + sheet.remark))
    parts = [f'<div class="rcac"><style>{STYLE}</style>']
    parts += [f"<h3>{title}</h3>"] if title else []
    parts.append(sheet_html(sheet, level=4))
    if draw is not None and find_spec("matplotlib") is not None:
        parts.append(svg_of(draw(), f"rcac{next(_numbers)}", sheet.title))
    return "\n".join([*parts, "</div>"])
