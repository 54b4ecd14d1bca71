"""What an entry of the ledger says, and the evidence that it names."""

from dataclasses import dataclass
from typing import Literal

Kind = Literal["formal", "symbolic", "property", "counterexample", "refutation"]
"""A theorem for all degrees, an identity of letters, a property test, a case in which the text is
false, and the theorem that refutes it."""


@dataclass(frozen=True)
class Formal:
    """A theorem of the formal part.

    Attributes
    ----------
    theorem : str
        ``folder.File.theorem``, a file of ``proofs/rocq`` without its suffix.
    says : str
        For which degrees, sizes and fields.
    of : tuple of int
        Which sentences of the conclusion it proves, from 1; all where there is one.
    """

    theorem: str
    says: str = ""
    of: tuple[int, ...] = (1,)


@dataclass(frozen=True)
class Symbolic:
    """An identity of letters.

    Attributes
    ----------
    check : str
        ``module.function`` of :mod:`proofs.symbolic`.
    sizes : tuple of int
        Sizes for which it is expanded, every coefficient a letter.
    extent : str
        How far an identity without sizes reaches; by default its letters are matrices of any size.
    of : tuple of int
        Which sentences of the conclusion it is about.
    """

    check: str
    sizes: tuple[int, ...] = ()
    extent: str = "any size"
    of: tuple[int, ...] = (1,)

    @property
    def scope(self) -> str:
        """The sizes for which the identity holds."""
        if not self.sizes:
            return self.extent
        return "sizes " + ", ".join(map(str, self.sizes))


@dataclass(frozen=True)
class Property:
    """A property that Hypothesis tries to refute with exact examples.

    Attributes
    ----------
    check : str
        ``module.name`` of :mod:`proofs.properties`.
    examples : int
        Examples of a full run, 10 or more.
    kept : float
        Least share of what is drawn that is to reach the predicate's answer.
    of : tuple of int
        Which sentences of the conclusion it is about.
    """

    check: str
    examples: int = 100
    kept: float = 0.5
    of: tuple[int, ...] = (1,)


@dataclass(frozen=True)
class Counterexample:
    """A case in which the text's wording is false.

    Attributes
    ----------
    refutes : str
        The wording.
    check : str
        ``module.function`` of :mod:`proofs.counterexamples`.
    formal : str or None
        ``folder.File.theorem`` of the formal refutation.
    in_text : bool
        Whether the text says so, or can be read so; if not, it is a hypothesis that the text states
        too, or shows to be needed, and the case tells why.
    """

    refutes: str
    check: str
    formal: str | None = None
    in_text: bool = True


@dataclass(frozen=True)
class Entry:
    """A statement that the software relies on.

    Attributes
    ----------
    name : str
        Identifier, as the command takes it.
    chapter : str
        ``2``, ``4``, ``7``, ``8``, ``9``, ``field``, ``A`` or ``B``.
    title, source : str
        What it is called, and its numbers in the dissertation.
    hypotheses : tuple of str
        The true ones.
    conclusion : tuple of str
        Its sentences; each needs evidence of its own.
    text : str
        What the dissertation says.
    difference : str
        How that differs from the truth; empty if it does not.
    relied_on_by : tuple of str
        Names of the software that use it.
    formal, symbolic, properties, counterexamples : tuple
        The evidence.
    """

    name: str
    chapter: str
    title: str
    source: str
    hypotheses: tuple[str, ...]
    conclusion: tuple[str, ...]
    text: str
    difference: str
    relied_on_by: tuple[str, ...]
    formal: tuple[Formal, ...] = ()
    symbolic: tuple[Symbolic, ...] = ()
    properties: tuple[Property, ...] = ()
    counterexamples: tuple[Counterexample, ...] = ()

    @property
    def theorems(self) -> tuple[str, ...]:
        """Every theorem of the formal part that the entry names, refutations included."""
        refutations = (c.formal for c in self.counterexamples if c.formal is not None)
        return (*(f.theorem for f in self.formal), *refutations)
