"""The claims of a file, whatever kind of experiment it is, and what their source leaves open."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.format.lists import ListOf, MapOf
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import brief, did_you_mean
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.format.values import Choice, Form, Integer, Real, Text
from rcac_numeric.experiments.judging.claim import OUTCOMES, RECORDS, AnyCheck, Claim, OpenItem
from rcac_numeric.experiments.judging.interval import STATISTICS, Check, quoted_interval

Measures = Mapping[str, Callable[..., float]]
REST = "the rest"
MOST = 200  # completions of one file


def _check(
    measure: Any,
    run: str = "",
    relative_to: str = "",
    statistic: str = "each",
    share: float = 1.0,
    until: int | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
    quoted: str = "",
    within: float | None = None,
) -> Any:
    """A measure of one run and the interval in which it must lie.

    Parameters
    ----------
    measure : str
        What is measured.
    run : str
        Of which run; that of the claim, or the main one, where it is left out.
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
        The interval; one of them is needed, or `quoted`.
    quoted : str
        In place of them: a number as the source prints it. The interval is half a unit of its last
        digit on both sides; where the measure has the key `value`, which is that number then, the
        measure may be as large as that half unit.
    within : number
        With `quoted`: how far from it, as a share of it.
    """
    return measure


def check_table(measures: Mapping[str, Table[Any]], *, given: Sequence[str] = ()) -> Table[Any]:
    """The table of a check, whose measures are these."""
    forms: dict[str, Form] = {
        "measure": Kinds(dict(measures)),
        "statistic": Choice(STATISTICS),
        "share": Real(),
        "until": Integer(1),
        "at_least": Real(),
        "at_most": Real(),
        "within": Real(),
    }
    return Table(_check, given=given, forms=forms)


def check_of(part: Part[Any], run: str) -> Check:
    """The check that a table makes; of this run where it names none."""
    given = {"run": run, **part.arguments}
    measure, within = given.pop("measure"), given.pop("within", None)
    arguments = dict(measure.arguments)
    if within is not None and not given.get("quoted"):
        raise InputError(f"within = {within} says how far from a number; give quoted too.")
    if given.get("quoted"):
        if "at_least" in given or "at_most" in given:
            raise InputError(
                f"quoted = {given['quoted']!r} is the interval; leave at_least and at_most out."
            )
        low, high = quoted_interval(given["quoted"], within)
        if "value" in arguments:
            if arguments["value"] != float(given["quoted"]):
                raise InputError(
                    f"value = {arguments['value']} is not the quoted {given['quoted']}."
                )
            given["at_most"] = (high - low) / 2
        else:
            given |= {"at_least": low, "at_most": high}
    return Check(measure=measure.make.__name__, arguments=arguments, **given)


def _claim(
    text: str = "",
    checks: list[Any] | None = None,
    quote: str = "",
    place: str = "",
    reading: str = "",
    misprint: str = "",
    completion: str = "",
    run: str = "",
    reason: str = "",
    verdict: str = "",
    verdicts: dict[str, str] | None = None,
    open: list[str] | None = None,
    over: dict[str, list[str]] | None = None,
    control: str = "",
    standard: str = "",
) -> Any:
    """Something said of the case.

    Parameters
    ----------
    text : str
        What the checks decide, in words of your own; the quote where it is left out.
    checks : tables
        What decides it: it holds where all of them do.
    quote, place : str
        The words of a source, and where they stand. A claim without them is your own: it has an
        outcome and no verdict.
    reading : str
        How words that leave room are read.
    misprint : str
        The slip of the print that is mended for the checks to be the right ones.
    completion : str
        What was chosen where the source is silent.
    run : str
        The run whose claim it is: checks that name none are of it. The main one where it is left
        out.
    reason : str
        Where it does not hold, or depends on something: why, in a sentence.
    verdict : str
        The verdict of record; exit status 1 says that a run gave another.
    verdicts : table
        In place of run and verdict, for several variants of a claim of your own: from the name of
        each run to the outcome of record.
    open : list of str
        The items of [[open]] that it is judged over, every combination of their values.
    over : table
        The map of record: from each outcome to the completions that have it, by the names of other
        runs and of the values of [[open]], several joined by "; ". "the rest" are all that are not
        named.
    control : str
        A run on which the same checks must succeed; without that a failure shows nothing.
    standard : str
        In place of text and checks: the name of a claim that every case with a target model can
        make of a run that keeps theta at steps 10^3, 10^4 and 10^5.
    """
    return text


def claim_table(check: Table[Any], standards: Sequence[str] = (), *, runs: bool = True) -> Table:  # type: ignore[type-arg]
    """The table of a claim, whose checks are of this table.

    Parameters
    ----------
    check : Table
    standards : sequence of str
        Names of claims that need no words and checks of their own.
    runs : bool
        Whether there are runs that it could be judged on.
    """
    given = () if standards else ("standard",)
    if not runs:
        given = (*given, "run", "verdicts", "open", "over", "control")
    forms: dict[str, Form] = {
        "checks": ListOf(check, 1),
        "verdict": Choice(RECORDS),
        "verdicts": MapOf(Choice(RECORDS)),
        "open": ListOf(Text()),
        "over": MapOf(ListOf(Text(), 1)),
    }
    if standards:
        forms["standard"] = Choice(tuple(standards))
    return Table(_claim, given=given, forms=forms)


def _completed(name: str) -> str:
    """One of the values that a reader would try.

    Parameters
    ----------
    name : str
        What it is: ``"k_w = 15"``.
    """
    return name


def _open_item(what: str, chosen: str, reason: str = "", values: Any = None) -> Any:
    """Something that the source leaves open.

    Parameters
    ----------
    what : str
        Its name; claims refer to it.
    chosen : str
        What the runs have, in words.
    reason : str
        What the source says of it, and why this was chosen.
    values : tables
        The others of the set that a reader would try: each has a name and the tables that it
        changes, as a run has. They run with `rcac verify --completions`.
    """
    return what


def open_table(value: Table[Any]) -> Table[Any]:
    """An item of [[open]], whose values are of this table."""
    return Table(_open_item, forms={"values": ListOf(value)})


def opens(value: Table[Any]) -> ListOf:
    """[[open]], whose values are of this table."""
    return ListOf(open_table(value), needed="an array of tables, [[open]]")


@dataclass(frozen=True, eq=False)
class OpenItems(Value):
    """What a source leaves open, with the tables of each value as they stand in the file."""

    items: tuple[OpenItem, ...]
    tables: Mapping[str, Mapping[str, Any]]

    @classmethod
    def of(cls, raw: Sequence[Mapping[str, Any]]) -> OpenItems:
        """From [[open]], which was read before, so that its keys are right."""
        items, tables = [], {}
        for entry in raw:
            values = entry.get("values", [])
            names = tuple(str(value["name"]) for value in values)
            items.append(OpenItem(entry["what"], entry["chosen"], entry.get("reason", ""), names))
            for name, value in zip(names, values, strict=True):
                if name in tables:
                    raise InputError(f"[[open]] has two values {brief(name)}; name each its own.")
                tables[name] = {key: inner for key, inner in value.items() if key != "name"}
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


def claims_of(
    part: Part[Any],
    runs: Sequence[str],
    items: OpenItems,
    make: Callable[[Part[Any], str], AnyCheck],
    standards: Mapping[str, Claim] | None = None,
) -> list[Claim]:
    """The claims that a table of [[claims]] makes: one, or one for each variant that it names.

    Parameters
    ----------
    part : Part
    runs : sequence of str
        The names of the runs, the main one first; none where nothing runs.
    items : OpenItems
    make : callable
        Makes a check of its table and the run that it is of.
    standards : mapping from names, optional
        Claims whose checks name no run.
    """
    said = _words_and_checks(part, standards or {})
    run, recorded = said.pop("run", ""), said.pop("verdict", "")
    verdicts = said.pop("verdicts", None)
    if verdicts is not None and (run or recorded):
        raise InputError(
            f"the claim {brief(said['text'])} has verdicts, so that run and verdict have no "
            "meaning; leave them out."
        )
    for name in [run, said.get("control", ""), *(verdicts or {})]:
        require_run(name, runs, "a claim")
    pairs = {run: recorded} if verdicts is None else verdicts
    return [_claim_of(said, name, verdict, runs, items, make) for name, verdict in pairs.items()]


def require_run(name: str, runs: Iterable[str], who: str) -> None:
    """Refuse the name of a run that is not there."""
    names = tuple(runs)
    if name and name not in names:
        raise InputError(
            f"{who} refers to the run {name!r}; the runs are {', '.join(names)}."
            f"{did_you_mean(name, names)}"
        )


def _words_and_checks(part: Part[Any], standards: Mapping[str, Claim]) -> dict[str, Any]:
    """What the table says, with what the standard claim that it names has in its place."""
    said = dict(part.arguments)
    name = said.pop("standard", "")
    own = [key for key in ("text", "checks") if key in said]
    if name and own:
        raise InputError(
            f"a claim is standard = {brief(name)}, so that {' and '.join(own)} have no meaning; "
            "leave them out."
        )
    if said.get("quote"):
        said.setdefault("text", said["quote"])
    if missing := [key for key in ("text", "checks") if not name and key not in said]:
        other = f", or standard, one of {', '.join(standards)}" if standards else ""
        raise InputError(f"a claim needs {' and '.join(missing)}{other}.")
    if name:
        said |= {"text": standards[name].text, "checks": standards[name].checks}
    return said


def _claim_of(
    said: Mapping[str, Any],
    run: str,
    recorded: str,
    runs: Sequence[str],
    items: OpenItems,
    make: Callable[[Part[Any], str], AnyCheck],
) -> Claim:
    of_run = run or (runs[0] if runs else "")
    checks = tuple(
        check.moved({"": of_run}) if isinstance(check, Check) else make(check, of_run)
        for check in said["checks"]
    )
    for check in checks:
        for name in check.runs:
            require_run(name, runs, "a claim")
        quoted = getattr(check, "quoted", "")
        if quoted and quoted not in said.get("quote", ""):
            raise InputError(
                f"quoted = {quoted!r} does not stand in the quote {brief(said.get('quote', ''))}."
            )
    judged_on = of_run if said.get("open") or said.get("over") or said.get("control") else run
    return Claim(
        **{
            **said,
            "checks": checks,
            "recorded": recorded,
            "run": judged_on,
            "over": _map(said, of_run, runs, items),
            "open": tuple(said.get("open", ())),
        }
    )


def _map(
    said: Mapping[str, Any], run: str, runs: Sequence[str], items: OpenItems
) -> dict[str, str]:
    """From the name of each completion to its outcome of record."""
    known = {item.what for item in items.items if item.completions}
    axes = [name for name in said.get("open", ()) if name in known]
    items.combinations([name for name in said.get("open", ()) if name not in known])
    left = ["; ".join(values) for values in items.combinations(axes)] if axes else []
    generated = set(left)
    found: dict[str, str] = {}
    for outcome, names in said.get("over", {}).items():
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
    for outcome, names in said.get("over", {}).items():
        if REST in names:
            found |= {completion_name(run, [name]): outcome for name in left}
            left = []
    return found | {completion_name(run, [name]): "" for name in left}
