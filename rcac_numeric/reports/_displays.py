"""Notebook output of results, and figures of exact results."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from itertools import count
from typing import Any

from compensator_theory import figures
from compensator_theory.errors import InputError
from compensator_theory.responses._time_responses import TimeResponse
from compensator_theory.stability._delayed_margins import DelayedStabilityMargins
from compensator_theory.stability._enclosed_margins import EnclosedStabilityMargins
from compensator_theory.stability._margins import StabilityMargins
from compensator_theory.stability._root_locus import RootLocus
from compensator_theory.systems._delayed_transfer_functions import DelayedTransferFunction
from compensator_theory.systems._transfer_functions import TransferFunction
from rcac_numeric.arrays._wording import in_a_line
from rcac_numeric.reports._rendering import sheet_html, words
from rcac_numeric.reports._sheet import Sheet
from rcac_numeric.reports._svg import svg_of


def picture_of(result: object, **options: Any) -> figures.Figure:
    """Return the figure of an exact result; an entry point names this function."""
    if isinstance(result, StabilityMargins | DelayedStabilityMargins | EnclosedStabilityMargins):
        from rcac_numeric.plots._margins import plot_stability_margins

        return plot_stability_margins(result, **options)
    if isinstance(result, RootLocus):
        from rcac_numeric.plots._root_locus import plot_root_locus

        return plot_root_locus(result, **options)
    if isinstance(result, TimeResponse):
        from rcac_numeric.plots._exact_systems import plot_time_response

        return plot_time_response(result, **options)
    if isinstance(result, TransferFunction | DelayedTransferFunction):
        from rcac_numeric.plots._exact_systems import plot_system

        return plot_system(result, **options)
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
    """A report in the colours of a notebook, and its figure below.

    Without Matplotlib it is the report alone.
    """
    title = words(in_a_line(sheet.title + sheet.remark))
    parts = [f'<div class="rcac"><style>{STYLE}</style>']
    parts += [f"<h3>{title}</h3>"] if title else []
    parts.append(sheet_html(sheet, level=4))
    if draw is not None and find_spec("matplotlib") is not None:
        parts.append(svg_of(draw(), f"rcac{next(_numbers)}", sheet.title))
    return "\n".join([*parts, "</div>"])
