"""The claims and figures of an estimation example's file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.experiments.claims import VERDICTS, Check, Claim
from rcac_numeric.experiments.estimation.measures import MEASURES
from rcac_numeric.experiments.figure_requests import FigureRequest
from rcac_numeric.experiments.format.lists import ListOf
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import did_you_mean
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.format.values import Choice, Integer, Real, Text

WINDOW = {"start": Integer(), "stop": Integer(1)}


def _estimation_check(
    measure: Any,
    run: str = "",
    relative_to: str = "",
    statistic: str = "each",
    share: float = 1.0,
    at_least: float | None = None,
    at_most: float | None = None,
) -> Any:
    """A measure of one run and the interval in which it must lie.

    Parameters
    ----------
    measure : str
        What is measured.
    run : str
        Of which run; that of the claim, or the first, where it is left out.
    relative_to : str
        Another run, whose measure it is divided by, seed by seed.
    statistic : {"each", "median"}
        Whether every seed must lie in the interval, or the median.
    share : number
        With "each": the least share of the seeds that must lie in it.
    at_least, at_most : number
        The interval; one of them is needed.
    """
    return measure


def _estimation_claim(
    text: str,
    checks: list[Any],
    claimed: str = "",
    correction: str = "",
    run: str = "",
    reason: str = "",
    verdict: str = "",
) -> Any:
    """Something said of the case.

    Parameters
    ----------
    text, claimed : str
        What is said, and what is claimed.
    checks : tables
        What decides it: it holds where all of them do.
    correction : str
        What had to be read differently from the source; that of the run where it is left out.
    run : str
        The run whose claim it is.
    reason : str
        Where it does not hold: why, in a sentence.
    verdict : str
        The verdict of record.
    """
    return text


CHECK = Table(
    _estimation_check,
    forms={
        "measure": Kinds({n: Table(f, given=["r"], forms=WINDOW) for n, f in MEASURES.items()}),
        "statistic": Choice(("each", "median")),
        "at_least": Real(),
        "at_most": Real(),
    },
)
CLAIM = Table(_estimation_claim, forms={"checks": ListOf(CHECK, 1), "verdict": Choice(VERDICTS)})
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


def estimation_claim(part: Part[Any], corrections: Mapping[str, str]) -> Claim:
    """The claim that a table makes.

    Parameters
    ----------
    part : Part
    corrections : mapping from names of runs, the first one being the main one
        What each run reads differently from the source.
    """
    said = dict(part.arguments)
    run, recorded = said.pop("run", ""), said.pop("verdict", "")
    require_run(run, corrections, "a claim")
    main = run or next(iter(corrections))
    checks = tuple(_check(check, main, corrections) for check in said.pop("checks"))
    defaults = {"claimed": "", "correction": corrections[main] if run else ""}
    return Claim(**{**defaults, **said, "checks": checks, "recorded": recorded, "run": run})


def estimation_figure(request: FigureRequest, runs: Mapping[str, str]) -> FigureRequest:
    """The figure that a table asks for, if its runs are there."""
    for name in request.runs:
        require_run(name, runs, "a figure")
    return request


def require_run(name: str, runs: Mapping[str, str], who: str) -> None:
    """Refuse the name of a run that is not there."""
    if name and name not in runs:
        raise InputError(
            f"{who} refers to the run {name!r}; the runs are {', '.join(runs)}."
            f"{did_you_mean(name, runs)}"
        )


def _check(part: Part[Any], main: str, runs: Mapping[str, str]) -> Check:
    arguments = {"run": main, **part.arguments}
    for name in ("run", "relative_to"):
        require_run(arguments.get(name, ""), runs, "a check")
    measure = arguments.pop("measure")
    return Check(measure=measure.make.__name__, arguments=measure.arguments, **arguments)
