"""Running the check that an erratum names."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_experiments.dissertation._entries import Erratum
from rcac_experiments.dissertation._tables import example_table
from rcac_experiments.experiments._experiment import verify
from rcac_experiments.files._builder import build
from rcac_experiments.judging._claim import DEPENDS, MISPRINT, REPRODUCED, UNDETERMINED
from rcac_numeric.arrays._values import Result, Value

EVIDENCE = "rcac_experiments.dissertation"
LEDGER = "proofs.counterexamples"
# The verdicts on a claim by which an erratum of a kind is shown; of the others any.
SHOWN_BY = {"misprint": (MISPRINT, REPRODUCED), "depends": (DEPENDS, UNDETERMINED)}


@dataclass(frozen=True)
class Finding(Value):
    """A sentence of a check, and whether it is so."""

    words: str
    holds: bool


@dataclass(frozen=True, eq=False)
class Checked(Result):
    """The result of an erratum's check.

    Attributes
    ----------
    erratum : Erratum
    facts : tuple of Finding
        Whether the printed statement fails and the corrected one holds.
    """

    _ANSWER = "holds"

    erratum: Erratum
    facts: tuple[Finding, ...]

    @property
    def holds(self) -> bool:
        """Whether all of its facts do; a check without facts shows nothing."""
        return bool(self.facts) and all(fact.holds for fact in self.facts)


def check_erratum(erratum: Erratum) -> Checked:
    """Run the evidence of an erratum: its check, the counterexample of the ledger, or its claim.

    Raises
    ------
    InputError
        If its evidence names what is not there, or is of the ledger of proofs, which only a
        checkout has.

    Examples
    --------
    >>> from rcac_experiments.dissertation import check_erratum, find_errata
    >>> checked = check_erratum(find_errata("(8.11)")[0])
    >>> checked.holds, checked.facts[0].words
    (True, 'gamma_0 + gamma_1 + gamma_2 = 3/2 as printed')
    """
    evidence = erratum.evidence
    if evidence.example:
        return Checked(erratum, (_fact_of_claim(erratum),))
    if evidence.counterexample:
        names = (evidence.counterexample, *evidence.others)
        return Checked(
            erratum, tuple(f for name in names for f in _facts(_resolved(LEDGER, name, erratum)))
        )
    if not evidence.check:
        raise InputError(f"the evidence of {erratum.name!r} cannot be run: {evidence.words}")
    return Checked(erratum, _facts(_resolved(EVIDENCE, evidence.check, erratum)))


def can_run(erratum: Erratum) -> bool:
    """Whether the evidence can run: the ledger of proofs is in a checkout only."""
    evidence = erratum.evidence
    if evidence.counterexample:
        return importlib.util.find_spec("proofs") is not None
    return bool(evidence.check or evidence.example)


def _resolved(package: str, name: str, erratum: Erratum) -> Callable[[], Iterable[tuple[str, Any]]]:
    module, _, function = name.partition(".")
    try:
        home = f"{package}.{module}" if module.isidentifier() else ""
        function_object = getattr(importlib.import_module(home), function)
        if function_object.__module__ != home:  # what the module imports is no check
            raise AttributeError(function)
    except (ImportError, ValueError, AttributeError):
        raise InputError(f"{package} has no check {name!r}; correct {erratum.name!r}.") from None
    checked: Callable[[], Iterable[tuple[str, Any]]] = function_object
    return checked


def _facts(check: Callable[[], Iterable[tuple[str, Any]]]) -> tuple[Finding, ...]:
    return tuple(Finding(words, _truth(words, holds)) for words, holds in check())


def _fact_of_claim(erratum: Erratum) -> Finding:
    """The claim that shows it has the verdict of record, and one that goes with the kind."""
    number = erratum.evidence.example
    experiment = build(example_table(number), number)
    claims = [c for c in experiment.claims if c.text.startswith(erratum.evidence.claim)]
    if not claims:
        raise InputError(f"example {experiment.id} has no such claim; correct {erratum.name!r}.")
    verdict = verify(experiment.held_out().only(claims[:1]).reduced()).verdicts[0]
    agrees = verdict.verdict in SHOWN_BY.get(erratum.kind, (verdict.verdict,))
    words = f"Example {experiment.id}, {claims[0].text!r}: {verdict.words}"
    return Finding(words, agrees and verdict.verdict == claims[0].recorded)


def _truth(words: str, holds: object) -> bool:
    """A bool of Python or NumPy; an expression that SymPy leaves open is no answer."""
    if not isinstance(holds, bool | np.bool_):
        raise TypeError(f"the check {words!r} gave {holds!r}, neither True nor False")
    return bool(holds)
