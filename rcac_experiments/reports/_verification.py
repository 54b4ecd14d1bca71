"""A verification as a report: the problem, the claims with their verdicts, the final controller."""

from __future__ import annotations

from typing import Any

import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_experiments.experiments._estimation_studies import StudyResult
from rcac_experiments.experiments._experiment import RunResult, Verification
from rcac_experiments.judging._claim import (
    DEPENDS,
    FAILS,
    HOLDS,
    MISPRINT,
    OURS,
    REPRODUCED,
    OpenItem,
    Verdict,
    outcome_of,
)
from rcac_numeric.analysis._predictive_limits import predictive_cost_limit
from rcac_numeric.checks._diagnosis import loop_health
from rcac_numeric.checks._health import LoopHealth
from rcac_numeric.controllers._predictive_cost import PredictiveCost
from rcac_numeric.engine._runs import Run
from rcac_numeric.reports._loop import (
    health_lines,
    health_record,
    joined,
    loop_section,
    missed_poles,
    poles_and_health,
    proof_of_run,
)
from rcac_numeric.reports._sheet import Block, Fact, Level, Section, Sheet, SheetTable, Text, cells

LEVELS: dict[str, Level] = {REPRODUCED: "good", MISPRINT: "good", HOLDS: "plain", FAILS: "plain"}
MOST_COMPLETIONS = 6  # of an outcome that are listed by name


def verification_sheet(verification: Verification) -> Sheet:
    """Return the report: problem, claims with measured values and verdicts, final controller."""
    experiment = verification.experiment
    health = loop_health(verification) if verification.results else None
    return Sheet(
        title=f"{experiment.id}  {experiment.title}",
        health=_health(verification, health),
        sections=(
            _problem(verification, health),
            _claims(verification),
            *_of_runs(verification),
        ),
        notes=experiment.notes,
    )


def _health(verification: Verification, health: LoopHealth | None) -> tuple[Text, ...]:
    if verification.estimates:
        return estimation_health(verification)
    if health is None:
        return _changed(verification) or (
            Text("Exact result, without a simulation or a tolerance."),
        )
    main = verification.main
    sentences: list[Text] = []
    poles: tuple[Text, ...] = ()
    if main.diverged:
        words = ", as expected" if main.as_expected else ""
        last = main.first.run.steps - 1
        sentences.append(
            Text(
                f"The loop diverged after step {last}{words}; the report shows the controller of "
                "that step.",
                "bad",
            )
        )
    elif not main.first.obstacle and not health.is_held:
        poles = missed_poles(main.first.comparison, main.first.structure)
    first, *rest = health_lines(health)
    sentences += poles_and_health(poles, [first])
    sentences += _changed(verification)
    sentences += [
        Text(f"Run {name!r} did not end as expected.", "bad") for name in verification.surprising
    ]
    return (*sentences, *rest, *proof_of_run(main.first)[0])


def _of_runs(verification: Verification) -> tuple[Section, ...]:
    """Return the sections of an example with runs."""
    if verification.estimates:
        return (estimation_section(verification),)
    if not verification.results:
        return ()
    main = verification.main
    remark = f" of run {main.specification.name!r}"
    loop = loop_section(main.first, "The controller", remark)
    return _runs(verification), loop, _predictive_limit(main.first.run)


def _predictive_limit(run: Run) -> Section:
    """Return the exact limit of predictive cost control, or the reason why there is none."""
    if not isinstance(run.settings, PredictiveCost):
        return Section()
    try:
        comparison = predictive_cost_limit(run)
    except CompensatorError as error:
        return Section("The exact limit", (Text(f"Not evaluated: {error}", "quiet"),))
    record = {
        "limit_pole_distance": comparison.worst_distance,
        "limit_backward_error": comparison.backward_error,
    }
    lines = tuple(Text(line) for line in str(comparison).splitlines())
    return Section("The exact limit", lines, record)


def _changed(verification: Verification) -> tuple[Text, ...]:
    """Return a sentence with the number of changed verdicts, if any."""
    count = sum(verdict.has_changed for verdict in verification.verdicts)
    return (Text(f"{count} of the recorded verdicts changed.", "bad"),) if count else ()


def _problem(verification: Verification, health: LoopHealth | None) -> Section:
    experiment = verification.experiment
    blocks: list[Block] = [Text(experiment.source, "quiet")] if experiment.source else []
    blocks += [Fact(name, words) for name, words in experiment.description.items() if words]
    record = {"id": experiment.id, "title": experiment.title}
    of_health = {"health": None, "warnings": []} if health is None else health_record(health)
    return Section("The problem", tuple(blocks), {**record, **of_health})


def _claims(verification: Verification) -> Section:
    """Return the claims of the source, then the additional claims."""
    verdicts = sorted(verification.verdicts, key=lambda v: v.claim.owner == OURS)
    quoted = any(v.claim.quote for v in verdicts)
    rows = tuple(
        cells(_words_of(v, quoted), [Text(str(r)) for r in v.results], _verdict(v))
        for v in verdicts
    )
    heads = ("sentence of the text" if quoted else "claim", "measured", "verdict")
    table = (SheetTable(heads, rows),)
    opens = tuple(Fact(item.what, _open_words(item)) for item in verification.experiment.open)
    open_items = Section("Settings that the text leaves open", opens) if opens else Section()
    record = {"claims": [claim_record(v) for v in verification.verdicts]}
    return joined("Claims" if rows else "", Section("", table if rows else (), record), open_items)


def claim_record(v: Verdict) -> dict[str, Any]:
    """Return a claim, its measured values and its verdict as a JSON object."""
    claim = v.claim
    return {
        "owner": claim.owner,
        "quote": claim.quote or None,
        "place": claim.place or None,
        "reading": claim.reading or None,
        "text": claim.text,
        "measured": v.measured,
        "verdict": v.verdict,
        "depends_on": list(claim.open) if v.verdict == DEPENDS else [],
        "outcomes": v.outcomes,
        "control": outcome_of(v.control) if v.control else None,
        "misprint": claim.misprint or None,
        "completion": claim.completion or None,
        "reason": _reason(v) or None,
        "run": claim.run or None,
        "recorded": claim.recorded or None,
    }


def _words_of(v: Verdict, beside_quotes: bool) -> list[Text]:
    claim = v.claim
    if claim.owner == OURS:
        return [Text(claim.text), *([Text("additional check", "quiet")] if beside_quotes else [])]
    sentences = [
        Text(f"\N{LEFT DOUBLE QUOTATION MARK}{claim.quote}\N{RIGHT DOUBLE QUOTATION MARK}")
    ]
    sentences.append(Text(claim.place, "quiet"))
    if claim.reading:
        sentences.append(Text(f"interpretation: {claim.reading}", "quiet"))
    if claim.text != claim.quote:
        sentences.append(Text(f"checked: {claim.text}", "quiet"))
    return sentences


def _open_words(item: OpenItem) -> str:
    others = f"; also simulated: {', '.join(item.completions)}" if item.completions else ""
    reason = f". {item.reason}" if item.reason else ""
    return f"chosen: {item.chosen}{others}{reason}"


def _verdict(verdict: Verdict) -> list[Text]:
    claim = verdict.claim
    lines = [Text(verdict.words, LEVELS.get(verdict.verdict, "warning"))]
    for name, words in (("misprint", claim.misprint), ("chosen", claim.completion)):
        if words:
            lines.append(Text(f"{name}: {words}", "quiet"))
    lines += [Text(line, "quiet") for line in map_lines(verdict)]
    if reason := _reason(verdict):
        lines.append(Text(reason, "quiet"))
    if verdict.has_changed:
        lines.append(Text(f"recorded verdict: {claim.recorded}", "bad"))
    return lines


def map_lines(verdict: Verdict) -> list[str]:
    """Return the completions for which a claim holds, and the result of its control run.

    Examples
    --------
    >>> from rcac_experiments import verify
    >>> from rcac_experiments.dissertation import load_example
    >>> from rcac_experiments.reports._verification import map_lines
    >>> map_lines(verify(load_example("B.5")).verdicts[0])
    []
    """
    outcomes = verdict.outcomes
    lines = []
    if len(outcomes) > 1:
        for outcome in dict.fromkeys(outcomes.values()):
            names = [name for name, result in outcomes.items() if result == outcome]
            text = (
                "; ".join(names) if len(names) <= MOST_COMPLETIONS else f"{len(names)} completions"
            )
            lines.append(f"{outcome}, of {len(outcomes)} completions: {text}")
    if verdict.control:
        control = outcome_of(verdict.control)
        lines.append(f"control, run {verdict.claim.control}: {control}")
    return lines


def _reason(verdict: Verdict) -> str:
    """Return the reason of a claim that does not hold."""
    return "" if verdict.verdict in (REPRODUCED, MISPRINT, HOLDS) else verdict.claim.reason


def _runs(verification: Verification) -> Section:
    """Return the table of all runs, which compares the arithmetics."""
    results = verification.results
    record = [
        {
            "name": name,
            "arithmetic": r.specification.algorithm,
            "outcome": r.first.run.outcome,
            "expected": r.specification.expected,
            "steps": r.first.run.steps,
            "updates_decided_by_rounding": r.first.run.guard_count,
            "theta": r.first.run.theta_final,
        }
        for name, r in results.items()
    ]
    heads = ("run", "arithmetic", "worst pole distance", "updates decided by rounding", "outcome")
    rows = tuple(_run(name, result) for name, result in results.items())
    if len(rows) == 1:
        return Section(record={"runs": record})
    return Section("Runs", (SheetTable(heads, rows),), {"runs": record})


def _run(name: str, result: RunResult) -> Any:
    first = result.first.run
    distance = ""
    if not result.first.obstacle:
        # The claims measure all seeds; the table shows the first.
        compared = result.repetitions[: 1 if result.specification.seeds > 1 else None]
        values = sorted(r.comparison.worst_distance for r in compared)
        distance = f"{values[len(values) // 2]:.3g}"
        if len(values) > 1:
            distance += f"  ({values[0]:.2g} to {values[-1]:.2g} of {len(values)})"
    arithmetic = result.specification.algorithm
    digits = getattr(first, "digits", None)
    if digits is not None:
        arithmetic += f", {digits:.0f} digits certified"
    guard = str(first.guard_count)
    outcome = [Text(first.outcome)]
    if result.diverged:
        known = ", as expected" if result.as_expected else ""
        level: Level = "quiet" if known else "bad"
        outcome = [Text(f"diverged at {first.steps}{known}", level)]
    elif not result.as_expected:
        outcome.append(Text("divergence was expected", "bad"))
    return cells(name, arithmetic, distance, guard, outcome)


# The report of an estimation example.


def estimation_health(verification: Verification) -> tuple[Text, ...]:
    """Return a warning for each run whose data do not determine the parameter."""
    results = verification.estimates
    undetermined = [name for name, result in results.items() if _initial_share(result) > 0.5]
    sentences = [
        Text(
            f"Run {name!r}: insufficient excitation, the data do not determine the parameter.",
            "warning",
        )
        for name in undetermined
    ]
    if not sentences:
        sentences = [Text("Estimates of a parameter with known true value.")]
    sentences += _changed(verification)
    return tuple(sentences)


def estimation_section(verification: Verification) -> Section:
    """Return the table of all runs: estimator, seeds and final estimate."""
    results = verification.estimates
    heads = ("run", "estimator", "seeds", "true final value", "final estimate", "outcome")
    rows = tuple(
        cells(
            name,
            result.study.estimator.words,
            str(result.study.seeds),
            f"{result.study.final_parameter:.5g}",
            _estimates(result),
            _outcome(result),
        )
        for name, result in results.items()
    )
    record = [
        {
            "name": name,
            "estimator": result.study.estimator.words,
            "steps": result.study.steps,
            "seeds": result.study.seeds,
            "truth": result.study.final_parameter,
            "estimates": list(_last(result)),
            "outcomes": [run.outcome for run in result.repetitions],
        }
        for name, result in results.items()
    ]
    return Section("Runs", (SheetTable(heads, rows),), {"runs": record})


def _last(result: StudyResult) -> tuple[float, ...]:
    return result.values("final_estimate", {})


def _initial_share(result: StudyResult) -> float:
    return max(result.values("initial_estimate_left", {}))


def _estimates(result: StudyResult) -> str:
    values = _last(result)
    if len(values) == 1:
        return f"{values[0]:.5g}"
    return f"{np.median(values):.5g}  ({min(values):.5g} to {max(values):.5g})"


def _outcome(result: StudyResult) -> str:
    lost = sum(run.outcome != "completed" for run in result.repetitions)
    return f"{lost} of {result.study.seeds} diverged" if lost else "completed"
