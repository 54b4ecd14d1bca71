"""The claims of a file, whatever kind of experiment it is, and what their source leaves open."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Annotated, Any, Literal

import attrs
import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.format.parts import Part, Shorthand
from rcac_numeric.experiments.format.places import brief, did_you_mean
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.format.values import Choice, Form, Integer, ListOf, MapOf, Text
from rcac_numeric.experiments.judging.claim import (
    OUTCOMES,
    RECORDS,
    AnyCheck,
    Check,
    Claim,
    OpenItem,
    quoted_interval,
)

REST = "the rest"
MOST = 200  # completions of one file
INTERVAL = "The interval; one of them is needed, or `quoted`."
QUOTE = (
    "The words of a source, and where they stand. A claim without them is your own: it has an "
    "outcome and no verdict."
)


@attrs.frozen(eq=False)
class CheckTable(Shorthand):
    """A measure of one run and the interval in which it must lie."""

    measure: Annotated[Part[float], "What is measured."]
    run: Annotated[
        str, "Of which run; that of the claim, or the main one, where it is left out."
    ] = ""
    relative_to: Annotated[
        str, "Another run, whose measure it is divided by, repetition by repetition."
    ] = ""
    statistic: Annotated[
        Literal["each", "median"],
        "Whether every seed or repetition must lie in the interval, or the median.",
    ] = "each"
    share: Annotated[
        float, 'With "each": the least share of them that must lie in the interval.'
    ] = 1.0
    until: Annotated[
        int | None,
        Integer(1),
        "A step at which theta is kept: the run is cut off before it, so that its controller is "
        "the one that is then in force and its plant that of the step before.",
    ] = None
    at_least: Annotated[float | None, INTERVAL] = None
    at_most: Annotated[float | None, INTERVAL] = None
    quoted: Annotated[
        str,
        "In place of them: a number as the source prints it. The interval is half a unit of its "
        "last digit on both sides; where the measure has the key `value`, which is that number "
        "then, the measure may be as large as that half unit.",
    ] = ""
    within: Annotated[float | None, "With `quoted`: how far from it, as a share of it."] = None

    def made(self) -> Check:
        """The check; of the run of its claim where it names none."""
        low, high = self._interval()
        return Check(
            measure=self.measure.make.__name__,
            arguments=self.measure.arguments,
            run=self.run,
            relative_to=self.relative_to,
            statistic=self.statistic,
            share=self.share,
            until=self.until,
            at_least=-np.inf if low is None else low,
            at_most=np.inf if high is None else high,
            quoted=self.quoted,
        )

    def _interval(self) -> tuple[float | None, float | None]:
        if not self.quoted:
            if self.within is not None:
                raise InputError(
                    f"within = {self.within} says how far from a number; give quoted too."
                )
            return self.at_least, self.at_most
        if self.at_least is not None or self.at_most is not None:
            raise InputError(
                f"quoted = {self.quoted!r} is the interval; leave at_least and at_most out."
            )
        low, high = quoted_interval(self.quoted, self.within)
        value = self.measure.arguments.get("value")
        if value is None:
            return low, high
        if value != float(self.quoted):
            raise InputError(f"value = {value} is not the quoted {self.quoted}.")
        return None, (high - low) / 2


def check_table(measures: Mapping[str, Table[Any]], *, given: Sequence[str] = ()) -> Table[Check]:
    """The table of a check, whose measures are these."""
    return Table(CheckTable, given=given, forms={"measure": Kinds(dict(measures))})  # type: ignore[arg-type]


@attrs.frozen(eq=False)
class ClaimTable(Value):
    """Something said of the case."""

    text: Annotated[
        str, "What the checks decide, in words of your own; the quote where it is left out."
    ] = ""
    checks: Annotated[Sequence[AnyCheck], "What decides it: it holds where all of them do."] = ()
    quote: Annotated[str, QUOTE] = ""
    place: Annotated[str, QUOTE] = ""
    reading: Annotated[str, "How words that leave room are read."] = ""
    misprint: Annotated[
        str, "The slip of the print that is mended for the checks to be the right ones."
    ] = ""
    completion: Annotated[str, "What was chosen where the source is silent."] = ""
    run: Annotated[
        str,
        "The run whose claim it is: checks that name none are of it. The main one where it is "
        "left out.",
    ] = ""
    reason: Annotated[
        str, "Where it does not hold, or depends on something: why, in a sentence."
    ] = ""
    verdict: Annotated[
        str,
        Choice(RECORDS),
        "The verdict of record; exit status 1 says that a run gave another.",
    ] = ""
    verdicts: Annotated[
        Mapping[str, str] | None,
        MapOf(Choice(RECORDS)),
        "In place of run and verdict, for several variants of a claim of your own: from the name "
        "of each run to the outcome of record.",
    ] = None
    open: Annotated[
        Sequence[str],
        ListOf(Text()),
        "The items of [[open]] that it is judged over, every combination of their values.",
    ] = ()
    over: Annotated[
        Mapping[str, Sequence[str]],
        MapOf(ListOf(Text(), 1)),
        "The map of record: from each outcome to the completions that have it, by the names of "
        'other runs and of the values of [[open]], several joined by "; ". "the rest" are all '
        "that are not named.",
    ] = attrs.field(factory=dict)
    control: Annotated[
        str, "A run on which the same checks must succeed; without that a failure shows nothing."
    ] = ""
    standard: Annotated[
        str,
        "In place of text and checks: the name of a claim that every case with a target model can "
        "make of a run that keeps theta at steps 10^3, 10^4 and 10^5.",
    ] = ""

    def claims(
        self,
        runs: Sequence[str],
        items: OpenItems,
        standards: Mapping[str, Claim] | None = None,
    ) -> list[Claim]:
        """What the table claims: one claim, or one for each variant that it names."""
        text, checks = self._words_and_checks(standards or {})
        if self.verdicts is not None and (self.run or self.verdict):
            raise InputError(
                f"the claim {brief(text)} has verdicts, so that run and verdict have no meaning; "
                "leave them out."
            )
        for name in [self.run, self.control, *(self.verdicts or {})]:
            require_run(name, runs, "a claim")
        pairs = {self.run: self.verdict} if self.verdicts is None else self.verdicts
        return [
            self._claim(text, checks, name, verdict, runs, items) for name, verdict in pairs.items()
        ]

    def _words_and_checks(self, standards: Mapping[str, Claim]) -> tuple[str, Sequence[AnyCheck]]:
        """Its own, or those of the standard claim that it names."""
        text = self.text or self.quote
        own = [name for name, has in (("text", self.text), ("checks", self.checks)) if has]
        if self.standard:
            if own:
                raise InputError(
                    f"a claim is standard = {brief(self.standard)}, so that {' and '.join(own)} "
                    "have no meaning; leave them out."
                )
            return standards[self.standard].text, standards[self.standard].checks
        if missing := [name for name, has in (("text", text), ("checks", self.checks)) if not has]:
            other = f", or standard, one of {', '.join(standards)}" if standards else ""
            raise InputError(f"a claim needs {' and '.join(missing)}{other}.")
        return text, self.checks

    def _claim(
        self,
        text: str,
        checks: Sequence[AnyCheck],
        run: str,
        recorded: str,
        runs: Sequence[str],
        items: OpenItems,
    ) -> Claim:
        of_run = run or (runs[0] if runs else "")
        own = tuple(check.moved({"": of_run}) for check in checks)
        for check in own:
            for name in check.runs:
                require_run(name, runs, "a claim")
            quoted = getattr(check, "quoted", "")
            if quoted and quoted not in self.quote:
                raise InputError(
                    f"quoted = {quoted!r} does not stand in the quote {brief(self.quote)}."
                )
        is_of_one_run = self.open or self.over or self.control
        return Claim(
            text=text,
            checks=own,
            quote=self.quote,
            place=self.place,
            reading=self.reading,
            misprint=self.misprint,
            completion=self.completion,
            recorded=recorded,
            run=of_run if is_of_one_run else run,
            reason=self.reason,
            over=self._map(of_run, runs, items),
            open=tuple(self.open),
            control=self.control,
        )

    def _map(self, run: str, runs: Sequence[str], items: OpenItems) -> dict[str, str]:
        """From the name of each completion to its outcome of record."""
        known = {item.what for item in items.items if item.completions}
        axes = [name for name in self.open if name in known]
        items.combinations([name for name in self.open if name not in known])
        left = ["; ".join(values) for values in items.combinations(axes)] if axes else []
        generated = set(left)
        found: dict[str, str] = {}
        for outcome, names in self.over.items():
            if outcome not in OUTCOMES:
                raise InputError(
                    f"over names the outcome {outcome!r}; there are {', '.join(OUTCOMES)}."
                    f"{did_you_mean(outcome, OUTCOMES)}"
                )
            for name in names:
                if name != REST:
                    if name not in generated:
                        require_run(name, runs, "over, the map of a claim,")
                    found[completion_name(run, [name]) if name in generated else name] = outcome
                    left = [other for other in left if other != name]
        for outcome, names in self.over.items():
            if REST in names:
                found |= {completion_name(run, [name]): outcome for name in left}
                left = []
        return found | {completion_name(run, [name]): "" for name in left}


def claim_table(
    check: Table[Any], standards: Sequence[str] = (), *, runs: bool = True
) -> Table[ClaimTable]:
    """The table of a claim, whose checks are of this table."""
    given = () if standards else ("standard",)
    if not runs:
        given = (*given, "run", "verdicts", "open", "over", "control")
    forms: dict[str, Form] = {"checks": ListOf(check, 1)}
    if standards:
        forms["standard"] = Choice(tuple(standards))
    return Table(ClaimTable, given=given, forms=forms)


@attrs.frozen(eq=False)
class OpenTable(Value):
    """Something that the source leaves open."""

    what: Annotated[str, "Its name; claims refer to it."]
    chosen: Annotated[str, "What the runs have, in words."]
    reason: Annotated[str, "What the source says of it, and why this was chosen."] = ""
    values: Annotated[
        Sequence[Any],
        "The others of the set that a reader would try: each has a name and the tables that it "
        "changes, as a run has. They run with `rcac verify --completions`.",
    ] = ()


def open_table(value: Table[Any]) -> Table[OpenTable]:
    """An item of [[open]], whose values are of this table."""
    return Table(OpenTable, forms={"values": ListOf(value)})


def opens(value: Table[Any]) -> ListOf:
    """[[open]], whose values are of this table."""
    return ListOf(open_table(value), needed="an array of tables, [[open]]")


@dataclass(frozen=True, eq=False)
class OpenItems(Value):
    """What a source leaves open, with the tables of each value as they stand in the file."""

    items: tuple[OpenItem, ...]
    tables: Mapping[str, Mapping[str, Any]]

    @classmethod
    def of(cls, read: Sequence[OpenTable]) -> OpenItems:
        """From the items of [[open]]."""
        items: list[OpenItem] = []
        tables: dict[str, dict[str, Any]] = {}
        for entry in read:
            names = tuple(value.name for value in entry.values)
            items.append(OpenItem(entry.what, entry.chosen, entry.reason, names))
            for value in entry.values:
                changes = attrs.asdict(value, recurse=False)
                name = changes.pop("name")
                if name in tables:
                    raise InputError(f"[[open]] has two values {brief(name)}; name each its own.")
                tables[name] = {key: v for key, v in changes.items() if v is not None}
        whats = [item.what for item in items]
        if twice := next((what for what in whats if whats.count(what) > 1), None):
            raise InputError(f"[[open]] names {brief(twice)} twice; give each item its own name.")
        return cls(tuple(items), tables)

    def combinations(self, names: Iterable[str]) -> list[tuple[str, ...]]:
        """Every combination of the values of these items, but for that of all that is chosen."""
        known = {item.what: item for item in self.items}
        for name in names:
            if name not in known:
                raise InputError(
                    f"a claim is open in {brief(name)}; [[open]] has {', '.join(known) or 'none'}."
                    f"{did_you_mean(name, known)}"
                )
        sets = [("", *known[name].completions) for name in names]
        made = [tuple(filter(None, values)) for values in product(*sets)]
        if len(made) > MOST:
            raise InputError(f"a claim is open in {len(made)} completions; {MOST} are allowed.")
        return [values for values in made if values]


def completed_runs(
    claims: Iterable[Claim], items: OpenItems
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The runs and the values of [[open]] that claims are judged over, each pair once."""
    seen = set()
    for claim in claims:
        runs = dict.fromkeys([claim.run, *(run for check in claim.checks for run in check.runs)])
        for values in items.combinations(claim.open) if claim.open else ():
            for run in runs:
                if (run, values) not in seen:
                    seen.add((run, values))
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
