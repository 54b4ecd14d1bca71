"""The claims of an experiment file: what is said of a case, and the checks that decide it."""

from __future__ import annotations

from typing import Any

from rcac_numeric.experiments.claims import VERDICTS, Check, Claim
from rcac_numeric.experiments.format.lists import ListOf, MapOf
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.format.values import Choice, Numbers, Real
from rcac_numeric.experiments.measures import MEASURES
from rcac_numeric.experiments.signal_measures import SIGNALS

FORMS = {"noise": MapOf(Numbers()), "signal": Choice(SIGNALS)}


def _check(
    measure: Any,
    run: str = "",
    relative_to: str = "",
    statistic: str = "each",
    at_least: float | None = None,
    at_most: float | None = None,
) -> Any:
    """A measure of one run and the interval in which it must lie.

    Parameters
    ----------
    measure : str
        What is measured.
    run : str
        Of which run; the main one where it is left out.
    relative_to : str
        Another run, whose measure it is divided by, repetition by repetition.
    statistic : {"each", "median"}
        Whether every repetition must lie in the interval, or the median.
    at_least, at_most : number
        The interval; one of them is needed.
    """
    return measure


def _claim(
    text: str, checks: list[Any], claimed: str = "", correction: str = "", verdict: str = ""
) -> Any:
    """Something said of the case.

    Parameters
    ----------
    text, claimed : str
        What is said, and the number or behaviour that is claimed.
    checks : tables
        What decides it: it holds where all of them do.
    correction : str
        What had to be read differently from the source for the checks to be the right ones.
    verdict : str
        The verdict of record; exit status 1 says that a run gave another.
    """
    return text


def _kinds() -> Kinds[Any]:
    """Every measure with its arguments; the run itself is given."""
    tables = {
        name: Table(function, given=["r"], forms=FORMS) for name, function in MEASURES.items()
    }
    return Kinds(tables)


CHECK = Table(
    _check,
    forms={
        "measure": _kinds(),
        "statistic": Choice(("each", "median")),
        "at_least": Real(),
        "at_most": Real(),
    },
)
CLAIM = Table(_claim, forms={"checks": ListOf(CHECK, 1), "verdict": Choice(VERDICTS)})


def claim_of(part: Part[Any], main_run: str) -> Claim:
    """The claim that a table of [[claims]] makes; checks without a run are of the main one."""
    arguments = dict(part.arguments)
    checks = tuple(_check_of(check, main_run) for check in arguments.pop("checks"))
    recorded = arguments.pop("verdict", "")
    return Claim(checks=checks, recorded=recorded, **{"claimed": "", **arguments})


def _check_of(part: Part[Any], main_run: str) -> Check:
    arguments = {"run": main_run, **part.arguments}
    measure = arguments.pop("measure")
    return Check(measure=measure.make.__name__, arguments=measure.arguments, **arguments)
