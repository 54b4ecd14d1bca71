"""The table of what shows each type of result: its picture, its report, its display in a notebook.

`rcac_numeric.arrays._showing` is how a result asks it. A type and what shows it are named, and
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
from rcac_numeric.arrays._wording import in_a_line
from rcac_numeric.reports._rendering import sheet_html, words
from rcac_numeric.reports._sheet import Sheet
from rcac_numeric.reports._svg import svg_of
from rcac_numeric.reports._terminal import as_text

# From a type to the function that draws it.
PICTURES = {
    "compensator_theory.stability._margins:StabilityMargins": (
        "rcac_numeric.plots._margins:plot_stability_margins"
    ),
    "compensator_theory.stability._root_locus:RootLocus": (
        "rcac_numeric.plots._root_locus:plot_root_locus"
    ),
    "rcac_numeric.analysis._exact_comparison:ExactComparison": (
        "rcac_numeric.plots._run:plot_comparison"
    ),
    "rcac_numeric.analysis._loop_analysis:LoopAnalysis": "rcac_numeric.plots._run:plot_sheet",
    "rcac_numeric.analysis._match:IntercalatedMatch": "rcac_numeric.plots._run:plot_match",
    "rcac_numeric.analysis._observer_forms:NumericObserverForms": (
        "rcac_numeric.plots._observer_forms:plot_observer_forms"
    ),
    "rcac_numeric.checks._check:ControllerCheck": "rcac_numeric.plots._check:plot_check",
    "rcac_numeric.engine._runs:Run": "rcac_numeric.plots._runs:plot_run",
    "rcac_numeric.estimation._estimates:ModeEstimates": ("rcac_numeric.plots._modes:plot_modes"),
    "rcac_numeric.analysis._lqg:LQG": "rcac_numeric.plots._lqg:plot_lqg",
    "rcac_numeric.analysis._classical:Margins": "rcac_numeric.plots._margins:plot_margins",
    "rcac_numeric.analysis._disk:DiskMargin": "rcac_numeric.plots._margins:plot_disk_margin",
    "rcac_numeric.plants.gallery._continuous:ContinuousPlant": (
        "rcac_numeric.plots._plants:plot_continuous_plant"
    ),
    "rcac_numeric.plants.gallery._zeros:ZeroPath": ("rcac_numeric.plots._plants:plot_zero_path"),
    "rcac_numeric.designing._design:Design": "rcac_numeric.plots._design:plot_design",
}

# From a type to the function that writes its report.
SHEETS = {
    "rcac_numeric.analysis._exact_comparison:ExactComparison": (
        "rcac_numeric.reports._loop:comparison_sheet"
    ),
    "rcac_numeric.analysis._loop_analysis:LoopAnalysis": (
        "rcac_numeric.reports._loop:analysis_sheet"
    ),
    "rcac_numeric.checks._check:ControllerCheck": "rcac_numeric.reports._check:check_sheet",
    "rcac_numeric.engine._runs:Run": "rcac_numeric.reports._loop:run_sheet",
    "rcac_numeric.analysis._lqg:LQG": "rcac_numeric.reports._lqg:lqg_sheet",
    "rcac_numeric.checks._health:LoopHealth": "rcac_numeric.reports._loop:health_sheet",
    "rcac_numeric.analysis._classical:Margins": "rcac_numeric.reports._check:margins_sheet",
    "rcac_numeric.designing._design:Design": "rcac_numeric.reports._design:design_sheet",
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
