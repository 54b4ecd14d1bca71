"""Checking entries: everything that they name, in order."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import Literal

from ..formal.rocq_build import Compilation
from ..formal.rocq_sources import missing
from .checks import run_counterexample, run_property, run_symbolic
from .entries import Entry
from .outcomes import Outcome, Verified

Tick = Callable[[str], None]


def number_of_checks(entries: Iterable[Entry]) -> int:
    """Count what :func:`verify` will compute, each check once.

    Examples
    --------
    >>> from proofs.ledger.ledger import select
    >>> from proofs.ledger.verification import number_of_checks
    >>> number_of_checks(select(["lemma-1"]))
    2
    """
    return len({key for entry in entries for key in _computed(entry)})


def verify(
    entries: Iterable[Entry],
    compilation: Compilation,
    *,
    quick: bool = False,
    tick: Tick = lambda check: None,
) -> tuple[Verified, ...]:
    """Run every check of the entries; a check that two entries name runs once.

    Parameters
    ----------
    entries : iterable of Entry
    compilation : Compilation
        What is known about the formal part.
    quick : bool
        All sizes of a symbolic check but the largest, a tenth of the examples of a property.
    tick : function
        Called with the name of each check when it has run.

    Examples
    --------
    >>> from proofs.ledger.ledger import select
    >>> from proofs.formal.rocq_build import NOT_COMPILED
    >>> from proofs.ledger.verification import verify
    >>> (verified,) = verify(select(["lemma-1"]), NOT_COMPILED, quick=True)
    >>> verified.holds, [outcome.kind for outcome in verified.outcomes]
    (True, ['formal', 'property', 'counterexample'])
    """
    known: dict[tuple[str, str], Outcome] = {}

    def once(key: tuple[str, str], run: Callable[[], Outcome]) -> Outcome:
        if key not in known:
            known[key] = run()
            tick(key[1])
        return known[key]

    def outcomes(entry: Entry) -> Iterator[Outcome]:
        for theorem in entry.formal:
            outcome = formal_outcome("formal", theorem.theorem, theorem.says, compilation)
            yield replace(outcome, of=theorem.of)
        for identity in entry.symbolic:
            outcome = once(
                ("symbolic", identity.check), partial(run_symbolic, identity, quick=quick)
            )
            yield replace(outcome, of=identity.of)
        for claim in entry.properties:
            outcome = once(("property", claim.check), partial(run_property, claim, quick=quick))
            yield replace(outcome, of=claim.of)
        for case in entry.counterexamples:
            outcome = once(("counterexample", case.check), partial(run_counterexample, case))
            yield replace(outcome, statement=case.refutes)
            if case.formal is not None:
                yield formal_outcome("refutation", case.formal, case.refutes, compilation)

    return tuple(Verified(entry, tuple(outcomes(entry))) for entry in entries)


def formal_outcome(
    kind: Literal["formal", "refutation"], theorem: str, says: str, compilation: Compilation
) -> Outcome:
    """Say what is known about a theorem after this run.

    Examples
    --------
    >>> from proofs.formal.rocq_build import NOT_COMPILED
    >>> from proofs.ledger.verification import formal_outcome
    >>> formal_outcome("formal", "Nowhere.nothing", "any n", NOT_COMPILED).status
    'missing'
    """
    if compilation.status in ("not asked", "not installed"):
        reason = missing(theorem)
        return Outcome(kind, theorem, says, "missing" if reason else "not compiled", detail=reason)
    reason = compilation.answers.get(theorem, "not asked of Coq")
    if reason:
        return Outcome(kind, theorem, says, "fails", detail=reason)
    return Outcome(kind, theorem, says, "holds", "no axioms")


def _computed(entry: Entry) -> Iterator[tuple[str, str]]:
    for kind, pieces in (
        ("symbolic", entry.symbolic),
        ("property", entry.properties),
        ("counterexample", entry.counterexamples),
    ):
        yield from ((kind, piece.check) for piece in pieces)
