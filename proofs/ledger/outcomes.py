"""The outcome of one piece of evidence."""

from dataclasses import dataclass
from typing import Literal

from .entries import Entry, Kind

Status = Literal["holds", "fails", "not compiled", "missing"]
"""The last two are for the formal part: present but not compiled in this run, and not there."""

NOTHING = "nothing checked in this run"
_STRENGTHS = {
    "formal": "machine-checked",
    "symbolic": "symbolic",
    "property": "property-tested",
}


@dataclass(frozen=True)
class Fact:
    """One computed fact of a counterexample.

    Examples
    --------
    >>> from proofs.ledger.outcomes import Fact
    >>> Fact("1 + 1 = 2", 1 + 1 == 2)
    Fact(statement='1 + 1 = 2', holds=True)
    """

    statement: str
    holds: bool


@dataclass(frozen=True)
class Outcome:
    """One piece of evidence after the run.

    Attributes
    ----------
    kind : str
        ``formal``, ``symbolic``, ``property`` or ``counterexample``.
    name : str
        The check or the theorem.
    statement : str
        What was checked, in words.
    status : str
        ``holds``, ``fails``, ``not compiled`` or ``missing``.
    scope : str
        For which sizes, or with how many examples.
    detail : str
        Why it fails; empty if it does not.
    facts : tuple of Fact
        Of a counterexample.
    of : tuple of int
        The sentences of the conclusion that it is about, from 1.
    """

    kind: Kind
    name: str
    statement: str
    status: Status
    scope: str = ""
    detail: str = ""
    facts: tuple[Fact, ...] = ()
    of: tuple[int, ...] = ()


@dataclass(frozen=True)
class Verified:
    """An entry with the outcomes of its evidence.

    Examples
    --------
    >>> from proofs.ledger.ledger import ledger
    >>> from proofs.ledger.outcomes import Outcome, Verified
    >>> lemma = next(entry for entry in ledger() if entry.name == "lemma-1")
    >>> print(Verified(lemma, (Outcome("symbolic", "a.b", "1 = 1", "holds", of=(1,)),)).strength)
    symbolic
    """

    entry: Entry
    outcomes: tuple[Outcome, ...]

    @property
    def holds(self) -> bool:
        """Whether nothing that was checked failed."""
        return all(outcome.status != "fails" for outcome in self.outcomes)

    @property
    def strengths(self) -> tuple[str, ...]:
        """For each sentence the strongest evidence that this run has seen hold."""
        return tuple(map(self._strength, range(1, len(self.entry.conclusion) + 1)))

    @property
    def strength(self) -> str:
        """That of its sentences; where they differ, the strongest of them and "in part"."""
        strength = min(self.strengths, key=[*_STRENGTHS.values(), NOTHING].index)
        return strength if len(set(self.strengths)) == 1 else f"{strength} in part"

    def _strength(self, sentence: int) -> str:
        for kind, words in _STRENGTHS.items():
            outcomes = [o for o in self.outcomes if o.kind == kind and sentence in o.of]
            if outcomes and all(o.status == "holds" for o in outcomes):
                return words
        return NOTHING
