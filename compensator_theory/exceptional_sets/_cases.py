"""The cases of a symbolic answer, and the case for given values of the symbols."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Generic, TypeVar

from sympy import Expr, Symbol

from compensator_theory._latex import displayed, latex, unless, words
from compensator_theory._printing import text
from compensator_theory.errors import CompensatorError, InputError
from compensator_theory.exceptional_sets._equations import irreducible_factors
from compensator_theory.polynomials._budget import quoted, repr_of
from compensator_theory.polynomials._decidable import require_decidable
from compensator_theory.polynomials._letters import names_in_all, reserved
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._substitution import Substitutions, read_values
from compensator_theory.polynomials._values import ExactValue

Answer = TypeVar("Answer")  # a docstring here breaks the documentation build


@dataclass(frozen=True)
class ExceptionalCase(ExactValue, Generic[Answer]):
    r"""The answer of a construction under conditions on its symbols.

    Attributes
    ----------
    values : tuple of pairs of sympy.Symbol and sympy.Expr
        Symbols that the equations were solved for, by those that stay free.
    zero : tuple of sympy.Expr
        Polynomials in the free symbols that are zero and could not be solved; empty otherwise.
    nonzero : tuple of sympy.Expr
        Irreducible polynomials in the free symbols that are not zero.
    not_all_zero : tuple of sympy.Expr
        Of a refusal: it holds where at least one of these is not zero. Empty: no such condition.
    answer : Answer or None
        The result of the construction for the substituted arguments, with its certificate; None
        where `reason` gives the cause.
    error : type or None
        The class of the refusal, or of the error that left the case open; None where the case was
        answered or not worked out.
    reason : str
        Message of that error, or why the case was not worked out.
    is_generic : bool
        Whether a refusal is known for generic values of the free symbols only.
    """

    values: tuple[tuple[Symbol, Expr], ...]
    zero: tuple[Expr, ...]
    nonzero: tuple[Expr, ...]
    not_all_zero: tuple[Expr, ...] = ()
    answer: Answer | None = None
    error: type[CompensatorError] | None = None
    reason: str = ""
    is_generic: bool = False

    @property
    def status(self) -> str:
        """Outcome of the case: "answered", "refused" (there is no answer), or "open"."""
        if not self.reason:
            return "answered"
        mathematical = self.error is not None and not issubclass(self.error, InputError)
        return "refused" if mathematical else "open"

    def contains(self, values: Substitutions, value: NumberLike | None = None) -> bool:
        """Tell whether the conditions hold for given real values of all symbols.

        They are given as to SymPy's `subs`.

        Raises
        ------
        InputError
            If a symbol of the conditions has no value.
        """
        numbers = {symbol.name: number for symbol, number in read_values(values, value).items()}
        require_decidable(numbers.values())

        def vanishes(expression: Expr) -> bool:
            missing = sorted(s.name for s in expression.free_symbols if s.name not in numbers)
            if missing:
                raise InputError(f"give a value for {', '.join(missing)}, too")
            at = {s: numbers[s.name] for s in expression.free_symbols}
            return irreducible_factors(expression.subs(at, simultaneous=True)) is None

        if any(vanishes(f) for f in self.nonzero) or not all(vanishes(f) for f in self.zero):
            return False
        if self.not_all_zero and all(vanishes(f) for f in self.not_all_zero):
            return False
        return all(vanishes(symbol - solved) for symbol, solved in self.values)

    @property
    def conditions(self) -> str:
        """The conditions in words, for instance "a = b**2, c != 0"."""
        parts = [f"{symbol} = {text(value)}" for symbol, value in self.values]
        parts += [f"{text(factor)} = 0" for factor in self.zero]
        parts += [f"{text(factor)} != 0" for factor in self.nonzero]
        if self.not_all_zero:
            parts.append(f"({', '.join(map(text, self.not_all_zero))}) not all 0")
        return ", ".join(parts) or "always"

    def _names(self) -> set[str]:
        """The symbols of the conditions, which the answer must not introduce."""
        return names_in_all(self.values, self.zero, self.nonzero, self.not_all_zero)

    def __str__(self) -> str:
        if self.status == "answered":
            with reserved(self._names()):
                return f"{self.conditions}: {' | '.join(str(self.answer).splitlines())}"
        generic = " for generic values" if self.is_generic else ""
        name = f" ({self.error.__name__})" if self.error else ""
        return f"{self.conditions}: {self.status}{generic}{name}: {quoted(self.reason)}"

    def _repr_latex_(self) -> str:
        return displayed(*self._formulas())

    def _formulas(self) -> tuple[str, str]:
        """The answer and its conditions."""
        conditions = [f"{latex(symbol)} = {latex(value)}" for symbol, value in self.values]
        conditions += [f"{latex(factor)} = 0" for factor in self.zero]
        conditions.append(unless(self.nonzero))
        if self.not_all_zero:
            conditions.append(rf"{latex(self.not_all_zero)} \neq 0")
        where = r", \; ".join(filter(None, conditions)) or words("always")
        if self.status == "answered":
            with reserved(self._names()):
                return latex(self.answer), where
        return words(self.error.__name__ if self.error else self.status), where


@dataclass(frozen=True)
class ExceptionalCases(ExactValue, Generic[Answer]):
    """All cases of a symbolic answer: every real value of the symbols lies in exactly one.

    Attributes
    ----------
    cases : tuple of ExceptionalCase
        The generic one first; each exceptional one stands after the case that it was taken from.
    """

    _REST: ClassVar[str] = ".cases lists them"
    cases: tuple[ExceptionalCase[Answer], ...]

    @property
    def generic(self) -> ExceptionalCase[Answer]:
        """The case of generic values."""
        return self.cases[0]

    @property
    def is_complete(self) -> bool:
        """Whether every case was answered or refused, for all values that its conditions allow."""
        return all(case.status != "open" and not case.is_generic for case in self.cases)

    def at(self, values: Substitutions, value: NumberLike | None = None) -> ExceptionalCase[Answer]:
        """Return the case in which given real values of all symbols lie, as to SymPy's `subs`.

        Raises
        ------
        InputError
            If a symbol has no value, or the values lie in no case: they are not real, or other
            than a symbol's assumptions allow.
        """
        numbers = read_values(values, value)
        for case in self.cases:
            if case.contains(numbers):
                return case
        raise InputError(
            f"{repr_of(numbers)} lies in no case; each value must be real and meet the "
            "assumptions of its symbol"
        )

    def __str__(self) -> str:
        return "\n".join(map(str, self.cases))

    def _repr_latex_(self) -> str:
        rows = r" \\ ".join(" & ".join(case._formulas()) for case in self.cases)
        return displayed(rf"\begin{{cases}} {rows} \end{{cases}}")
