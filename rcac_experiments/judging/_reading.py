"""Read the claims of a file, and the settings that their source leaves open."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import attrs

from compensator_theory.errors import InputError
from rcac_experiments.format._places import Location, did_you_mean, quoted
from rcac_experiments.format._tables import Kinds, Table
from rcac_experiments.format._values import Choice, Form, ListOf, MapOf, String
from rcac_experiments.judging._claim import (
    OUTCOMES,
    RECORDS,
    AnyCheck,
    Check,
    Claim,
    OpenItem,
)

REST = "the rest"
MOST = 200  # completions of one file


def check_table(
    measures: Mapping[str, Table[Any]], *, supplied: Sequence[str] = ()
) -> Table[Check]:
    """Return the table of a check with these measures."""
    forms: dict[str, Form] = {"measure": Kinds(dict(measures))}
    return Table(Check, supplied=("arguments", *supplied), forms=forms)


class Outcomes(MapOf):
    """A table from outcomes to completions, read as a mapping from completions to outcomes."""

    def read(self, value: object, place: Location) -> dict[str, str]:
        """Return the outcome of each completion."""
        named = super().read(value, place)
        for outcome in named:
            if outcome not in OUTCOMES:
                raise InputError(
                    f"over: the outcome {outcome!r} must be one of {', '.join(OUTCOMES)}."
                    f"{did_you_mean(outcome, OUTCOMES)}"
                )
        return {name: outcome for outcome, names in named.items() for name in names}


def claim_table(
    check: Table[Any], standards: Sequence[str] = (), *, runs: bool = True
) -> Table[Claim]:
    """Return the table of a claim with checks of this table."""
    standard_keys = () if standards else ("standard",)
    if not runs:
        standard_keys = (*standard_keys, "run", "verdicts", "open", "over", "control")
    verdict = Choice(RECORDS)
    forms: dict[str, Form] = {
        "checks": ListOf(check, 1),
        "recorded": verdict,
        "verdicts": MapOf(verdict),
        "open": ListOf(String()),
        "over": Outcomes(ListOf(String(), 1)),
    }
    if standards:
        forms["standard"] = Choice(tuple(standards))
    return Table(Claim, supplied=standard_keys, forms=forms, names={"recorded": "verdict"})


def claims_of(
    read: Claim,
    runs: Sequence[str],
    items: Sequence[OpenItem],
    standards: Mapping[str, Claim] | None = None,
) -> list[Claim]:
    """Return the claims of a table: one, or one for each run of its verdicts."""
    text, checks = _words_and_checks(read, standards or {})
    if read.verdicts is not None and (read.run or read.recorded):
        raise InputError(
            f"the claim {quoted(text)} has verdicts, which replace run and verdict; remove "
            "run and verdict."
        )
    for name in [read.run, read.control, *(read.verdicts or {})]:
        require_run(name, runs, "a claim")
    claims = []
    pairs = {read.run: read.recorded} if read.verdicts is None else read.verdicts
    for run, recorded in pairs.items():
        of_run = run or (runs[0] if runs else "")
        is_of_one_run = read.open or read.over or read.control
        claims.append(
            attrs.evolve(
                read,
                text=text,
                checks=_checks_of(of_run, checks, read.quote, runs),
                recorded=recorded,
                verdicts=None,
                open=tuple(read.open),
                run=of_run if is_of_one_run else run,
                over=_map(read, of_run, runs, items),
                standard="",
            )
        )
    return claims


def _words_and_checks(
    read: Claim, standards: Mapping[str, Claim]
) -> tuple[str, Sequence[AnyCheck]]:
    """Return text and checks of a claim, or of the standard claim that it names."""
    text = read.text or read.quote
    keys = [name for name, has in (("text", read.text), ("checks", read.checks)) if has]
    if read.standard:
        if keys:
            raise InputError(
                f"a claim has standard = {quoted(read.standard)}, which replaces "
                f"{' and '.join(keys)}; remove {' and '.join(keys)}."
            )
        return standards[read.standard].text, standards[read.standard].checks
    if missing := [name for name, has in (("text", text), ("checks", read.checks)) if not has]:
        other = f", or standard, one of {', '.join(standards)}" if standards else ""
        raise InputError(f"a claim needs {' and '.join(missing)}{other}.")
    return text, read.checks


def _checks_of(
    run: str, checks: Sequence[AnyCheck], quote: str, runs: Sequence[str]
) -> tuple[AnyCheck, ...]:
    """Return the checks with the run of the claim as default; refuse unknown runs."""
    of_run = tuple(check.moved({"": run}) for check in checks)
    for check in of_run:
        for name in check.runs:
            require_run(name, runs, "a claim")
        number = getattr(check, "quoted", "")
        if number and number not in quote:
            raise InputError(f"quoted = {number!r} must be part of the quote {quoted(quote)}.")
    return of_run


def _map(read: Claim, run: str, runs: Sequence[str], items: Sequence[OpenItem]) -> dict[str, str]:
    """Return the recorded outcome of each completion of a run."""
    known = {item.what for item in items if item.completions}
    axes = [name for name in read.open if name in known]
    combinations([name for name in read.open if name not in known], items)
    values = ["; ".join(values) for values in combinations(axes, items)] if axes else []
    named = {name: outcome for name, outcome in read.over.items() if name != REST}
    for name in named:
        if name not in values:
            require_run(name, runs, "over, the map of a claim,")
    rest = {value: read.over.get(REST, "") for value in values if value not in named}
    return {
        completion_name(run, [name]) if name in values else name: outcome
        for name, outcome in (named | rest).items()
    }


def open_table(value: Table[Any]) -> Table[OpenItem]:
    """Return the table of an item of [[open]] with values of this table."""
    return Table(OpenItem, forms={"values": ListOf(value)})


def opens(value: Table[Any]) -> ListOf:
    """Return the array [[open]] with values of this table."""
    return ListOf(open_table(value), needed="an array of tables, [[open]]")


def tables_of(items: Sequence[OpenItem]) -> dict[str, dict[str, Any]]:
    """Return the tables of each value of [[open]], by its name."""
    tables: dict[str, dict[str, Any]] = {}
    for value in (value for item in items for value in item.values):
        changes = attrs.asdict(value, recurse=False)
        name = changes.pop("name")
        if name in tables:
            raise InputError(
                f"[[open]] has two values {quoted(name)}; give each value a different name."
            )
        tables[name] = {key: v for key, v in changes.items() if v is not None}
    names = [item.what for item in items]
    if twice := next((what for what in names if names.count(what) > 1), None):
        raise InputError(
            f"[[open]] has two items {quoted(twice)}; give each item a different name."
        )
    return tables


def combinations(names: Sequence[str], items: Sequence[OpenItem]) -> list[tuple[str, ...]]:
    """Return all combinations of values of these items, except the chosen one."""
    known = {item.what: item for item in items}
    for name in names:
        if name not in known:
            raise InputError(
                f"open = {quoted(name)} of a claim must be an item of [[open]]: "
                f"{', '.join(known) or 'none'}."
                f"{did_you_mean(name, known)}"
            )
    sets = [("", *known[name].completions) for name in names]
    choices = [tuple(filter(None, values)) for values in product(*sets)]
    if len(choices) > MOST:
        raise InputError(f"a claim has {len(choices)} completions; at most {MOST} are allowed.")
    return [values for values in choices if values]


def completed_runs(
    claims: Iterable[Claim], items: Sequence[OpenItem]
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield each pair of a run and values of [[open]] that a claim needs, once."""
    names = set()
    for claim in claims:
        runs = dict.fromkeys([claim.run, *(run for check in claim.checks for run in check.runs)])
        for values in combinations(claim.open, items) if claim.open else ():
            for run in runs:
                if (run, values) not in names:
                    names.add((run, values))
                    yield run, values


def completion_name(run: str, values: Sequence[str]) -> str:
    """Return the name of the completion of a run by values of [[open]]."""
    return f"{run}; {'; '.join(values)}" if run else "; ".join(values)


def require_run(name: str, runs: Iterable[str], who: str) -> None:
    """Refuse the name of an unknown run."""
    names = tuple(runs)
    if name and name not in names:
        raise InputError(
            f"{who} refers to the run {name!r}; the runs are {', '.join(names)}."
            f"{did_you_mean(name, names)}"
        )
