"""A construction on its exceptional set, repeated until no new exceptional polynomial appears."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from typing import Any, Generic

import sympy
from sympy import Expr, Symbol

from compensator_theory._printing import text
from compensator_theory.errors import (
    CompensatorError,
    FunctionFailedError,
    InputError,
    NotControllableError,
    NotObservableError,
)
from compensator_theory.exceptional_sets._cases import Answer, ExceptionalCase, ExceptionalCases
from compensator_theory.exceptional_sets._equations import (
    Conditions,
    distinct,
    irreducible_factors,
    solutions,
)
from compensator_theory.polynomials._budget import integer, repr_of
from compensator_theory.polynomials._carrying import require_no_functions
from compensator_theory.polynomials._generic_answers import generic_answer
from compensator_theory.polynomials._letters import reserved
from compensator_theory.polynomials._substitution import names_in, require_variable, substituted
from compensator_theory.polynomials._variables import is_operator

WITHOUT_VARIABLE = {"MatrixLike", "SpectrumLike", "NumberLike", "Time", "int", "str", "bool"}
"""Annotations of arguments in which no symbol can be mistaken for the variable."""


def exceptional_cases(
    function: Callable[..., Answer], /, *arguments: Any, cases: int = 100, **options: Any
) -> ExceptionalCases[Answer]:
    r"""Answer with symbols, also where the generic answer fails: all cases, with their conditions.

    .. math:: \text{answer where } p_1 \ne 0, \ldots, p_k \ne 0; \qquad
              \text{for every } i: \text{ again where } p_i = 0,\ p_1 \ne 0, \ldots, p_{i-1} \ne 0

    Parameters
    ----------
    function : callable
        A construction whose answer has the attribute `exceptional`: :func:`place_poles`,
        :func:`solve_diophantine`, :func:`smith_form` and the like, or a function of your own that
        returns such an answer or a tuple of them. Or one of this package that answers by a plain
        value, such as :func:`mcmillan_degree`, :func:`is_controllable` or :func:`regulator_gain`,
        by a system or a matrix, such as :func:`transfer_function` or :func:`hankel_matrix`, or by a
        decision that speaks of all values itself, such as :func:`stability_region`.
    *arguments, **options
        What it takes. Symbols are substituted in texts, polynomials, matrices, systems and lists.
    cases : int, optional
        How many times the function is called at most; the remaining cases are open.

    Returns
    -------
    ExceptionalCases
        Each case is answered, with the certificate that the function gives, or refused by an error
        with the reason, or open: the equation could not be solved for a symbol,
        the budget was exceeded, or the input has another shape there.

    Raises
    ------
    InputError
        If `function` cannot be called, its answer has no exceptional set, or it refuses the input
        as it was given.
    FunctionFailedError
        If it raises an error, or uses symbols that are not in its arguments.

    Notes
    -----
    The symbols stand for real numbers that meet their assumptions. An equation
    :math:`c x + d = 0` gives :math:`x = -d/c` where :math:`c \ne 0`, and a separate case where
    :math:`c = d = 0`; one in a single symbol gives its real roots, within the budget of number
    fields; others stay open. A refusal is followed to where it falls if the error says where that
    is (:meth:`CompensatorError.holding`), and else said to hold for generic values. The idea is
    that of comprehensive Groebner systems: V. Weispfenning, J. Symbolic Computation 14 (1992).

    Examples
    --------
    >>> from compensator_theory import exceptional_cases, solve_diophantine
    >>> analysis = exceptional_cases(solve_diophantine, "s - a", "s - b", "s - c", variable="s")
    >>> for case in analysis.cases:
    ...     print(case.conditions, "->", case.status)
    a - b != 0 -> answered
    a = b, b - c != 0 -> refused
    a = c, b = c -> answered
    >>> print(analysis.cases[-1])
    a = c, b = c: x = 1 + t*(1), y = 0 + t*(-1)
    >>> analysis.cases[1].error.__name__, analysis.is_complete
    ('NoSolutionError', True)
    """
    if not callable(function):
        raise InputError(
            f"{repr_of(function)} cannot be called; give a function, then its arguments"
        )
    integer(cases, "cases", at_least=1)
    require_no_functions((arguments, options))
    work = _Analysis(function, arguments, options, cases)
    return ExceptionalCases(tuple(work.of(Conditions())))


class _Analysis(Generic[Answer]):
    def __init__(
        self,
        function: Callable[..., Answer],
        arguments: tuple[Any, ...],
        options: dict[str, Any],
        left: int,
    ) -> None:
        self.function, self.arguments, self.options = function, arguments, options
        self.left = left
        self.names = names_in((arguments, options))
        self.meanings: dict[str, str] = {}  # symbols that answers introduce, with their meaning
        self.parameters: set[str] = set()  # symbols of coefficients, which are no variable
        self.knows_variable = _names_its_variable(function, arguments, options)

    def of(self, conditions: Conditions) -> Iterator[ExceptionalCase[Answer]]:
        """Yield the case for generic values, then its exceptional cases."""
        if conditions.unsolved:
            yield _case(conditions, reason=conditions.unsolved)
            return
        if not self.left:
            yield _case(conditions, reason="more cases than requested; raise cases=")
            return
        self.left -= 1
        is_first = not conditions.values
        try:
            arguments = self._arguments(conditions)
            options = {
                name: _option(name, value, conditions) for name, value in self.options.items()
            }
            companion = generic_answer(self.function)
            if companion is not None:
                answer, nonzero_conditions = self._call(companion, arguments, options)
                divisors = tuple(nonzero_conditions)
            else:
                answer = self._call(self.function, arguments, options)
                divisors = _exceptional(answer, must_have=is_first)
            self._require_arguments(divisors, answer, conditions)
        except CompensatorError as error:
            if isinstance(error, FunctionFailedError) or (
                is_first and isinstance(error, InputError)
            ):
                raise
            yield from self._refused(conditions, error)
            return
        factors = distinct(divisors, conditions.nonzero)
        yield _case(conditions.assuming(*factors), answer=answer)
        yield from self._where_zero(conditions, factors)

    def _require_arguments(
        self, divisors: tuple[Expr, ...], answer: object, conditions: Conditions
    ) -> None:
        """Refuse symbols of a function that its arguments lack: no substitution reaches them."""
        used = {s.name for divisor in divisors for s in divisor.free_symbols}
        names = names_in((self.arguments, self.options)) - {s.name for s in conditions.values}
        for part in answer if isinstance(answer, tuple) else (answer,):
            # symbols that the answer defines
            introduced_symbols = getattr(part, "exponentials", ())
            self.meanings.update(
                (x.name, f"{x} = {text(value)}") for x, value in introduced_symbols
            )
        self.parameters |= used
        if missing := sorted(used - names - self.meanings.keys()):
            raise FunctionFailedError(
                f"the function uses {', '.join(missing)} besides its arguments; pass the objects "
                "with these symbols as arguments, so that values can be substituted"
            )

    def _call(
        self, function: Callable[..., Any], arguments: tuple[Any, ...], options: dict[str, Any]
    ) -> Any:
        try:
            with reserved(self.names):  # one letter means one thing in all cases
                return function(*arguments, **options)
        except CompensatorError:
            raise
        except Exception as error:
            name = getattr(self.function, "__name__", repr_of(self.function))
            raise FunctionFailedError(f"{name} failed: {type(error).__name__}: {error}") from error

    def _arguments(self, conditions: Conditions) -> tuple[Any, ...]:
        values = [*self.arguments, *self.options.values()]
        named = {x if isinstance(x, str) else x.name for x in values if isinstance(x, str | Symbol)}
        parts = []
        for argument in self.arguments:
            parts.append(substituted(argument, conditions.values))
            if conditions.values and not (self.knows_variable or named & names_in(argument)):
                parameters = self.parameters | {s.name for s in conditions.values}
                require_variable(argument, parts[-1], parameters)
        return tuple(parts)

    def _where_zero(
        self, conditions: Conditions, factors: tuple[Expr, ...]
    ) -> Iterator[ExceptionalCase[Answer]]:
        for index, factor in enumerate(factors):
            if meanings := [
                self.meanings[s.name] for s in factor.free_symbols if s.name in self.meanings
            ]:
                reason = f"{text(factor)} = 0 is not solved where {', '.join(sorted(meanings))}"
                pending = conditions.assuming(*factors[:index]).also_zero(factor)
                yield _case(pending, reason=reason)
                continue
            for case in solutions(conditions.assuming(*factors[:index]).also_zero(factor)):
                yield from self.of(case)

    def _refused(
        self, conditions: Conditions, error: CompensatorError
    ) -> Iterator[ExceptionalCase[Answer]]:
        """Yield the cases of a refusal, also those where its conditions fail."""
        if isinstance(error, InputError):
            yield _case(conditions, error=type(error), reason=str(error))
            return
        if isinstance(error, NotControllableError | NotObservableError):
            error.holding([1])  # a rank that is not full for generic values is not full for any
        if error.unless is None:
            left = names_in((self.arguments, self.options)) - {s.name for s in conditions.values}
            generic = any(not is_operator(Symbol(name)) for name in left)
            yield _case(conditions, error=type(error), reason=str(error), generic=generic)
            return
        factors = distinct(map(_expression, error.exceptional), conditions.nonzero)
        holds = conditions.assuming(*factors)
        unless = [irreducible_factors(_expression(e)) for e in error.unless]
        nonzero = [product for product in unless if product is not None]
        falls: tuple[Expr, ...] = ()
        if all(set(product) - set(holds.nonzero) for product in nonzero):
            falls = tuple(_expression(e) for e in error.unless)
        one = len(nonzero) == 1
        at_least_one = falls if not one else ()
        refused_case = holds.assuming(*nonzero[0]) if one else holds
        yield _case(refused_case, error=type(error), reason=str(error), not_all_zero=at_least_one)
        if falls:
            for case in solutions(holds.also_zero(*falls)):
                yield from self.of(case)
        yield from self._where_zero(conditions, factors)


def _names_its_variable(
    function: Callable[..., Any], arguments: tuple[Any, ...], options: dict[str, Any]
) -> bool:
    """Whether the variable is named or absent, so that no symbol is mistaken for it.

    Plain matrices (`MatrixLike`) show no variable.
    """
    try:
        signature = inspect.signature(function)
        bound = signature.bind_partial(*arguments, **options).arguments
    except (TypeError, ValueError):
        return False
    kinds = {str(signature.parameters[name].annotation).split(" | ")[0] for name in bound}
    named = "variable" in bound and bound["variable"] is not None
    return named or ("MatrixLike" in kinds and kinds <= WITHOUT_VARIABLE)


def _case(
    conditions: Conditions,
    *,
    answer: Answer | None = None,
    error: type[CompensatorError] | None = None,
    reason: str = "",
    not_all_zero: tuple[Expr, ...] = (),
    generic: bool = False,
) -> ExceptionalCase[Answer]:
    values = sorted(conditions.values.items(), key=lambda pair: str(pair[0].name))
    zero = conditions.pending
    return ExceptionalCase(
        tuple(values), zero, conditions.nonzero, not_all_zero, answer, error, reason, generic
    )


def _option(name: str, value: Any, conditions: Conditions) -> Any:
    """Return the value of an option; a word such as "y" is no symbol."""
    if not isinstance(value, str) or not value.isidentifier():
        return substituted(value, conditions.values)
    if value in {symbol.name for symbol in conditions.values}:
        raise InputError(
            f"the option {name} = {value!r} and a symbol have one name; rename the symbol"
        )
    return value


def _exceptional(answer: object, *, must_have: bool) -> tuple[Expr, ...]:
    answers = answer if isinstance(answer, tuple) else (answer,)
    factors: list[Expr] = []
    for part in answers:
        factors_of_part = getattr(part, "exceptional", None)
        if factors_of_part is None and must_have:
            raise InputError(
                f"the function returned a {type(part).__name__}, which has no exceptional set; "
                "give one whose answer has the attribute `exceptional`"
            )
        factors += factors_of_part or ()
    return tuple(factors)


def _expression(value: object) -> Expr:
    return sympy.sympify(value)
