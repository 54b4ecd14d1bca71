"""Running the check that an erratum names."""

from __future__ import annotations

import importlib
from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.values import Value
from rcac_numeric.dissertation.errata.entries import Erratum

EVIDENCE = "rcac_numeric.dissertation.errata.evidence"


@dataclass(frozen=True)
class Fact(Value):
    """A sentence of a check, and whether it is so."""

    words: str
    holds: bool


@dataclass(frozen=True, eq=False)
class Checked(Value):
    """What the check of an erratum found.

    Attributes
    ----------
    erratum : Erratum
    facts : tuple of Fact
        That what is printed fails, and that what is said to be true holds.
    """

    erratum: Erratum
    facts: tuple[Fact, ...]

    @property
    def holds(self) -> bool:
        """Whether all of its facts do; a check without facts shows nothing."""
        return bool(self.facts) and all(fact.holds for fact in self.facts)


def check_erratum(erratum: Erratum) -> Checked:
    """Run the check of an erratum.

    Raises
    ------
    InputError
        If its evidence is of another kind, or names a check that is not there.

    Examples
    --------
    >>> from rcac_numeric.dissertation import check_erratum, find_errata
    >>> checked = check_erratum(find_errata("(8.11)")[0])
    >>> checked.holds, checked.facts[0].words
    (True, 'as printed the weights add up to 7/3 for n = 3, alpha = 1')
    """
    if not erratum.evidence.check:
        raise InputError(f"the evidence of {erratum.name!r} is no check: {erratum.evidence.words}")
    module, _, name = erratum.evidence.check.partition(".")
    try:
        home = f"{EVIDENCE}.{module}" if module.isidentifier() else ""
        found = getattr(importlib.import_module(home), name)
        if found.__module__ != home:  # what the module imports is no check
            raise AttributeError(name)
    except (ImportError, ValueError, AttributeError):
        raise InputError(
            f"{EVIDENCE} has no check {erratum.evidence.check!r}; correct {erratum.name!r}."
        ) from None
    facts = tuple(Fact(words, _truth(words, holds)) for words, holds in found())
    return Checked(erratum, facts)


def _truth(words: str, holds: object) -> bool:
    """A bool of Python or NumPy; an expression that SymPy leaves open is no answer."""
    if not isinstance(holds, bool | np.bool_):
        raise TypeError(f"the check {words!r} gave {holds!r}, neither True nor False")
    return bool(holds)
