"""The claims of an experiment file: what is said of a case, and the checks that decide it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.experiments.claims import VERDICTS, Check, Claim
from rcac_numeric.experiments.format.lists import ListOf, MapOf
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import brief, did_you_mean
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.format.values import Choice, Integer, Numbers, Real
from rcac_numeric.experiments.measures.measures import MEASURES
from rcac_numeric.experiments.measures.signal_measures import SIGNALS

# The claims that every case with a target model can make: what RCAC fits, and what explains it.

STEPS = (1_000, 10_000, 100_000)  # at which the dissertation's figures and ours stop to look
NEAR = 0.1  # of the size of G_f, or of the power of the response to w
BETTER = 0.5  # of the distance at the first of the steps


def _at_steps(measure: str) -> tuple[Check, ...]:
    """The measure at each of the steps, the median over seeds; the run is that of the claim."""
    return tuple(
        Check(measure=measure, run="", until=k, statistic="median", at_most=NEAR) for k in STEPS
    )


STANDARD_CLAIMS = {
    "intercalated match": Claim(
        text="At steps 10^3, 10^4 and 10^5 the frequency response of the intercalated transfer "
        "function approximates that of the target model G_f: it is within 10 % of it at half of "
        "the frequencies.",
        claimed="approximates",
        checks=_at_steps("median_match"),
    ),
    "match improves": Claim(
        text="As RCAC adapts, the intercalated transfer function tends to G_f: at step 10^5 it is "
        "at most half as far from it as at step 10^3.",
        claimed="tends to, end of section 4.4",
        checks=(
            Check(
                measure="match_change",
                run="",
                until=STEPS[-1],
                statistic="median",
                at_most=BETTER,
                arguments={"since": STEPS[0]},
            ),
        ),
    ),
    "residual split": Claim(
        text="What RCAC's fit leaves over at steps 10^3, 10^4 and 10^5 is the response to w, which "
        "no controller takes away, and not the matching error, which has less than a tenth of its "
        "power.",
        claimed="the two parts of (4.14)",
        checks=_at_steps("matching_error_share"),
    ),
}


FORMS = {"noise": MapOf(Numbers()), "signal": Choice(SIGNALS)}


def _check(
    measure: Any,
    run: str = "",
    relative_to: str = "",
    statistic: str = "each",
    share: float = 1.0,
    until: int | None = None,
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
        Whether every seed or repetition must lie in the interval, or the median.
    share : number
        With "each": the least share of them that must lie in the interval.
    until : int
        A step at which theta is kept: the run is cut off before it, so that its controller is the
        one that is then in force and its plant that of the step before.
    at_least, at_most : number
        The interval; one of them is needed.
    """
    return measure


def _claim(
    text: str = "",
    checks: list[Any] | None = None,
    claimed: str = "",
    correction: str = "",
    run: str = "",
    reason: str = "",
    verdict: str = "",
    verdicts: dict[str, str] | None = None,
    standard: str = "",
) -> Any:
    """Something said of the case.

    Parameters
    ----------
    text, claimed : str
        What is said, and the number or behaviour that is claimed.
    checks : tables
        What decides it: it holds where all of them do.
    correction : str
        What had to be read differently from the source for the checks to be the right ones; that
        of the run where it is left out.
    run : str
        The run whose claim it is: checks that name none are of it. The main one where it is left
        out.
    reason : str
        Where it does not hold: why, in a sentence.
    verdict : str
        The verdict of record; exit status 1 says that a run gave another.
    verdicts : table
        In place of run and verdict, for several variants: from the name of each run to the
        verdict of record that the claim has for it.
    standard : str
        In place of text, claimed and checks: the name of a claim that every case with a target
        model can make of a run that keeps theta at steps 10^3, 10^4 and 10^5.
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
        "share": Real(),
        "until": Integer(1),
        "at_least": Real(),
        "at_most": Real(),
    },
)
CLAIM = Table(
    _claim,
    forms={
        "checks": ListOf(CHECK, 1),
        "verdict": Choice(VERDICTS),
        "verdicts": MapOf(Choice(VERDICTS)),
        "standard": Choice(tuple(STANDARD_CLAIMS)),
    },
)


def claims_of(part: Part[Any], corrections: Mapping[str, str]) -> list[Claim]:
    """The claims that a table of [[claims]] makes: one, or one for each variant that it names.

    Parameters
    ----------
    part : Part
    corrections : mapping from names of runs, the main one first
        What each run reads differently from the source.
    """
    said = _words_and_checks(part)
    run, recorded = said.pop("run", ""), said.pop("verdict", "")
    verdicts = said.pop("verdicts", None)
    if verdicts is not None and (run or recorded):
        raise InputError(
            f"the claim {brief(said['text'])} has verdicts, so that run and verdict have no "
            "meaning; leave them out."
        )
    for name in [run, *(verdicts or {})]:
        if name and name not in corrections:
            raise InputError(
                f"a claim refers to the run {name!r}; the runs are {', '.join(corrections)}."
                f"{did_you_mean(name, corrections)}"
            )
    pairs = {run: recorded} if verdicts is None else verdicts
    return [_claim_of(said, name, verdict, corrections) for name, verdict in pairs.items()]


def _words_and_checks(part: Part[Any]) -> dict[str, Any]:
    """What the table says, with what the standard claim that it names has in its place."""
    said = dict(part.arguments)
    name = said.pop("standard", "")
    own = [key for key in ("text", "checks", "claimed") if key in said]
    if name and own:
        raise InputError(
            f"a claim is standard = {brief(name)}, so that {' and '.join(own)} have no meaning; "
            "leave them out."
        )
    if missing := [key for key in ("text", "checks") if not name and key not in said]:
        raise InputError(
            f"a claim needs {' and '.join(missing)}, or standard, one of "
            f"{', '.join(STANDARD_CLAIMS)}."
        )
    if not name:
        return said
    standard = STANDARD_CLAIMS[name]
    told = {key: getattr(standard, key) for key in ("text", "claimed", "checks")}
    return {**said, **told}


def _claim_of(
    said: Mapping[str, Any], run: str, recorded: str, corrections: Mapping[str, str]
) -> Claim:
    of_run = run or next(iter(corrections))
    checks = tuple(_check_of(check, of_run) for check in said["checks"])
    defaults = {"claimed": "", "correction": corrections[of_run] if run else ""}
    return Claim(**{**defaults, **said, "checks": checks, "recorded": recorded, "run": run})


def _check_of(part: Part[Any] | Check, main_run: str) -> Check:
    if isinstance(part, Check):
        return replace(part, run=main_run)
    arguments = {"run": main_run, **part.arguments}
    measure = arguments.pop("measure")
    return Check(measure=measure.make.__name__, arguments=measure.arguments, **arguments)
