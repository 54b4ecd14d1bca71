"""Errata and their evidence."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Annotated

import attrs

from compensator_theory.errors import InputError
from rcac_experiments.format._values import Choice
from rcac_numeric.arrays._values import Result

KINDS = {
    "misprint": "a slip that a reader corrects by looking twice",
    "inconsistent": "two places of the text disagree",
    "needs a hypothesis": "true where the text means it, and false without a condition that is "
    "not written",
    "unstated": "data without which the example cannot be run, or a number compared",
    "depends": "true of some completions of the open settings, not of others",
    "false": "not true as it stands, and no charitable reading was found by a second reader",
}
EVIDENCE = {
    "check": "by a check that runs",
    "ledger": "by the ledger of proofs",
    "example": "by a claim of an example",
}
_EQUATION = re.compile(r"\(([1-9AB]\.\d+)\)(?:-\(([1-9AB])\.(\d+)\))?")
_NAMED = re.compile(
    r"(Example|Table|Figure|Section|Theorem|Proposition) ([1-9AB][\d.]*\d|[A-B]?\d)"
)


@attrs.frozen(eq=False)
class ErratumEvidence(Result):
    """The evidence of an erratum: one of three kinds, each of which runs.

    Attributes
    ----------
    check : str
        ``module.function`` of `rcac_experiments.dissertation`.
    ledger, counterexample : str
        An entry of the ledger of proofs and, where there is one, the case that refutes the print.
    example, claim : str
        The number of an example, and the words that its claim begins with.
    others : sequence of str
        Further counterexamples of the ledger.
    """

    check: str = ""
    ledger: str = ""
    counterexample: str = ""
    example: str = ""
    claim: str = ""
    others: Sequence[str] = attrs.field(default=(), converter=tuple)

    def __attrs_post_init__(self) -> None:
        kinds = [name for name in EVIDENCE if getattr(self, name)]
        if len(kinds) != 1:
            raise InputError(
                f"evidence is exactly one of {', '.join(EVIDENCE)}; given are {kinds or 'none'}."
            )
        if bool(self.example) != bool(self.claim):
            raise InputError("example and claim go together: a claim of which example?")
        if self.others and not self.counterexample:
            raise InputError("further counterexamples follow a first one; name it.")
        if self.counterexample and not self.ledger:
            raise InputError("a counterexample belongs to an entry of the ledger; name it.")

    @property
    def kind(self) -> str:
        """A key of `EVIDENCE`."""
        return next(name for name in EVIDENCE if getattr(self, name))

    @property
    def words(self) -> str:
        """The entry in one line."""
        if self.check:
            return f"check {self.check}"
        if self.ledger:
            case = f", refuted by {self.counterexample}" if self.counterexample else ""
            return f"ledger of proofs: {self.ledger}{case}"
        return f"Example {self.example}: {self.claim}"


@attrs.frozen(eq=False)
class Erratum(Result):
    """One place of the dissertation that is wrong or incomplete.

    Attributes
    ----------
    name : str
        Identifier.
    where : str
        Equations, examples, sections, captions.
    kind : str
        A key of `KINDS`.
    printed, true : str
        The printed statement, and the true one.
    evidence : ErratumEvidence
    charity : str
        The charitable reading that was tried first, and why it does not save the print.
    chapter : str
        1 to 9, A or B.

    Examples
    --------
    >>> from rcac_experiments.dissertation import find_errata
    >>> entry = find_errata("(A.16)")[0]
    >>> entry.where, entry.equations
    ('(A.15)-(A.17), (4.24), Example A.2', ('A.15', 'A.16', 'A.17', '4.24'))
    """

    name: str
    where: str
    kind: Annotated[str, Choice(tuple(KINDS))]
    printed: str
    true: str
    evidence: ErratumEvidence
    charity: str = ""
    chapter: str = ""

    def __attrs_post_init__(self) -> None:
        for part in ("name", "where", "printed", "true"):
            if not getattr(self, part):
                raise InputError(f"an erratum needs {part}; write what it is.")

    @property
    def equations(self) -> tuple[str, ...]:
        """The numbers of its equations, ranges written out."""
        return tuple(self._equations())

    @property
    def named(self) -> tuple[str, ...]:
        """Its examples, tables, sections and so on, such as ``Example 7.1``."""
        return tuple(f"{kind} {number}" for kind, number in _NAMED.findall(self.where))

    def _equations(self) -> Iterator[str]:
        for first, chapter, last in _EQUATION.findall(self.where):
            item_chapter, start = first.split(".")
            stop = int(last) if chapter == item_chapter else int(start)
            yield from (f"{item_chapter}.{i}" for i in range(int(start), stop + 1))
