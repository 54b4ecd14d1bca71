"""The claims of a file, whatever kind of experiment it is, and what their source leaves open."""

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
    """The table of a check, whose measures are these."""
    forms: dict[str, Form] = {"measure": Kinds(dict(measures))}
    return Table(Check, supplied=("arguments", *supplied), forms=forms)


class Outcomes(MapOf):
    """A table from each outcome to the completions that have it, kept the other way round."""

    def read(self, value: object, place: Location) -> dict[str, str]:
        """From the name of each completion to its outcome."""
        named = super().read(value, place)
        for outcome in named:
            if outcome not in OUTCOMES:
                raise InputError(
                    f"over names the outcome {outcome!r}; there are {', '.join(OUTCOMES)}."
                    f"{did_you_mean(outcome, OUTCOMES)}"
                )
        return {name: outcome for outcome, names in named.items() for name in names}


def claim_table(
    check: Table[Any], standards: Sequence[str] = (), *, runs: bool = True
) -> Table[Claim]:
    """The table of a claim, whose checks are of this table."""
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
    """What a claim of a file claims of these runs: itself, or one of each variant that it names."""
    text, checks = _words_and_checks(read, standards or {})
    if read.verdicts is not None and (read.run or read.recorded):
        raise InputError(
            f"the claim {quoted(text)} has verdicts, so that run and verdict have no meaning; "
            "leave them out."
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
    """Its own, or those of the standard claim that it names."""
    text = read.text or read.quote
    keys = [name for name, has in (("text", read.text), ("checks", read.checks)) if has]
    if read.standard:
        if keys:
            raise InputError(
                f"a claim is standard = {quoted(read.standard)}, so that {' and '.join(keys)} "
                "have no meaning; leave them out."
            )
        return standards[read.standard].text, standards[read.standard].checks
    if missing := [name for name, has in (("text", text), ("checks", read.checks)) if not has]:
        other = f", or standard, one of {', '.join(standards)}" if standards else ""
        raise InputError(f"a claim needs {' and '.join(missing)}{other}.")
    return text, read.checks


def _checks_of(
    run: str, checks: Sequence[AnyCheck], quote: str, runs: Sequence[str]
) -> tuple[AnyCheck, ...]:
    """Checks of a run where they name none, if all that they need is there."""
    of_run = tuple(check.moved({"": run}) for check in checks)
    for check in of_run:
        for name in check.runs:
            require_run(name, runs, "a claim")
        number = getattr(check, "quoted", "")
        if number and number not in quote:
            raise InputError(f"quoted = {number!r} does not stand in the quote {quoted(quote)}.")
    return of_run


def _map(read: Claim, run: str, runs: Sequence[str], items: Sequence[OpenItem]) -> dict[str, str]:
    """From the name of each completion of a run to its outcome of record."""
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
    """An item of [[open]], whose values are of this table."""
    return Table(OpenItem, forms={"values": ListOf(value)})


def opens(value: Table[Any]) -> ListOf:
    """[[open]], whose values are of this table."""
    return ListOf(open_table(value), needed="an array of tables, [[open]]")


def tables_of(items: Sequence[OpenItem]) -> dict[str, dict[str, Any]]:
    """The tables of each value of [[open]] as they stand in the file, by the value's name."""
    tables: dict[str, dict[str, Any]] = {}
    for value in (value for item in items for value in item.values):
        changes = attrs.asdict(value, recurse=False)
        name = changes.pop("name")
        if name in tables:
            raise InputError(f"[[open]] has two values {quoted(name)}; name each its own.")
        tables[name] = {key: v for key, v in changes.items() if v is not None}
    names = [item.what for item in items]
    if twice := next((what for what in names if names.count(what) > 1), None):
        raise InputError(f"[[open]] names {quoted(twice)} twice; give each item its own name.")
    return tables


def combinations(names: Sequence[str], items: Sequence[OpenItem]) -> list[tuple[str, ...]]:
    """Every combination of the values of the items of these names, but for all that is chosen."""
    known = {item.what: item for item in items}
    for name in names:
        if name not in known:
            raise InputError(
                f"a claim is open in {quoted(name)}; [[open]] has {', '.join(known) or 'none'}."
                f"{did_you_mean(name, known)}"
            )
    sets = [("", *known[name].completions) for name in names]
    combinations = [tuple(filter(None, values)) for values in product(*sets)]
    if len(combinations) > MOST:
        raise InputError(f"a claim is open in {len(combinations)} completions; {MOST} are allowed.")
    return [values for values in combinations if values]


def completed_runs(
    claims: Iterable[Claim], items: Sequence[OpenItem]
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The runs and the values of [[open]] that claims are judged over, each pair once."""
    names = set()
    for claim in claims:
        runs = dict.fromkeys([claim.run, *(run for check in claim.checks for run in check.runs)])
        for values in combinations(claim.open, items) if claim.open else ():
            for run in runs:
                if (run, values) not in names:
                    names.add((run, values))
                    yield run, values


def completion_name(run: str, values: Sequence[str]) -> str:
    """What the completion of a run by values of [[open]] is called."""
    return f"{run}; {'; '.join(values)}" if run else "; ".join(values)


def require_run(name: str, runs: Iterable[str], who: str) -> None:
    """Refuse the name of a run that is not there."""
    names = tuple(runs)
    if name and name not in names:
        raise InputError(
            f"{who} refers to the run {name!r}; the runs are {', '.join(names)}."
            f"{did_you_mean(name, names)}"
        )
