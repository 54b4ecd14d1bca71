"""What became of one piece of evidence."""

from dataclasses import dataclass
from typing import Literal

from .entries import Entry, Kind

Status = Literal["holds", "fails", "not compiled", "missing"]
"""The last two are for the formal part: present but not compiled in this run, and not there."""


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
    """

    kind: Kind
    name: str
    statement: str
    status: Status
    scope: str = ""
    detail: str = ""
    facts: tuple[Fact, ...] = ()


@dataclass(frozen=True)
class Verified:
    """An entry with the outcomes of its evidence.

    Examples
    --------
    >>> from proofs.ledger.ledger import ledger
    >>> from proofs.ledger.outcomes import Outcome, Verified
    >>> print(Verified(ledger()[0], (Outcome("symbolic", "a.b", "1 = 1", "holds"),)).strength)
    symbolic
    """

    entry: Entry
    outcomes: tuple[Outcome, ...]

    @property
    def holds(self) -> bool:
        """Whether nothing that was checked failed."""
        return all(outcome.status != "fails" for outcome in self.outcomes)

    @property
    def strength(self) -> str:
        """The strongest evidence that this run has seen hold."""
        in_part = all(theorem.part for theorem in self.entry.formal)
        for kind, words in (
            ("formal", "machine-checked in part" if in_part else "machine-checked"),
            ("symbolic", "symbolic"),
            ("property", "property-tested"),
        ):
            of_kind = [o for o in self.outcomes if o.kind == kind]
            if of_kind and all(o.status == "holds" for o in of_kind):
                return words
        return "nothing checked in this run"
