"""The claims and figures of an estimation example's file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rcac_numeric.experiments.estimation.measures import MEASURES
from rcac_numeric.experiments.figure_requests import FigureRequest
from rcac_numeric.experiments.format.lists import ListOf
from rcac_numeric.experiments.format.tables import Table
from rcac_numeric.experiments.format.values import Choice, Integer, Text
from rcac_numeric.experiments.judging.reading import check_table, claim_table, require_run

WINDOW = {"start": Integer(), "stop": Integer(1)}
CHECK: Table[Any] = check_table(
    {n: Table(f, given=["r"], forms=WINDOW) for n, f in MEASURES.items()}, given=["until"]
)
CLAIM: Table[Any] = claim_table(CHECK)
FIGURE = Table(
    FigureRequest,
    given=["channel", "noise", "direct", "designs"],
    forms={
        "kind": Choice(("estimates", "responses", "distribution")),
        "runs": ListOf(Text()),
        "signal": Choice(("z",)),
        "first": Integer(0),
        "last": Integer(1),
        "measure": Choice(tuple(MEASURES)),
    },
)


def estimation_figure(request: FigureRequest, runs: Sequence[str]) -> FigureRequest:
    """The figure that a table asks for, if its runs are there."""
    for name in request.runs:
        require_run(name, runs, "a figure")
    return request
