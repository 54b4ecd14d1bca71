"""The decision whether a compensator is observer-based, with its reason."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sympy import Poly

from compensator_theory._latex import displayed, latex, words
from compensator_theory.observers._form_lists import ObserverForms
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._certified import Root, certified_roots

NumberOfForms = int | Literal["a continuum"] | None
"""Number of forms; None if it is unknown."""


@dataclass(frozen=True)
class ObserverDecision(ExactValue):
    r"""Whether a compensator is observer-based, and why.

    Attributes
    ----------
    question : str
        The question: about a polynomial pair, a transfer function, a realisation, or about LQG.
    answer : bool or None
        None if it is undecided: it depends on the values of symbols, a root lies on the boundary of
        stability, or no certified ball was small enough. `reason` names the case.
    reason : str
        In words of this input.
    number_of_forms : int, "a continuum" or None
        Of observer-based forms. None if they were not counted: the answer is None, or does not rest
        on forms (an unstable loop), the closed loop has symbols or irrational coefficients, or
        forms with irrational or symbolic regulators could not be counted.
    characteristic_polynomial : sympy.Poly or None
        Closed-loop polynomial on which the answer rests; None where it rests on orders or a direct
        term alone.
    forms : ObserverForms or None
        The forms that were enumerated; None where the answer rests on something else.

    Notes
    -----
    A decision is true or false in an ``if``; an undecided one raises InputError there.
    """

    _ANSWER = "answer"

    question: str
    answer: bool | None
    reason: str
    number_of_forms: NumberOfForms = None
    characteristic_polynomial: Poly | None = None
    forms: ObserverForms | None = None

    @property
    def roots(self) -> tuple[Root, ...]:
        """Certified closed-loop roots with their multiplicities, the evidence for parity."""
        if self.characteristic_polynomial is None:
            return ()
        return certified_roots(self.characteristic_polynomial)

    @property
    def verdict(self) -> str:
        """The answer and its reason in one sentence."""
        count = "" if self.number_of_forms is None else f" Forms: {self.number_of_forms}."
        return f"{self.question} {self._word}: {self.reason}.{count}"

    @property
    def _word(self) -> str:
        return {True: "yes", False: "no", None: "undecided"}[self.answer]

    def __str__(self) -> str:
        if self.characteristic_polynomial is None:
            return self.verdict
        return f"{self.verdict}\nClosed loop: {format_polynomial(self.characteristic_polynomial)}"

    def _repr_latex_(self) -> str:
        if self.characteristic_polynomial is None:
            return displayed(words(self.verdict))
        loop = rf"\tilde D = {latex(self.characteristic_polynomial)}"
        return displayed(words(f"{self.question} {self._word}"), loop)
