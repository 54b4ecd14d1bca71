"""Substitution of values for symbols in systems and in arguments of constructions."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import fields, replace
from typing import Any, TypeAlias, TypeVar

import sympy
from sympy import Basic, Expr, MatrixBase, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import repr_of
from compensator_theory.polynomials._carrying import polynomial_with_functions
from compensator_theory.polynomials._expressions import WORDS, read_text
from compensator_theory.polynomials._functions import functions_in
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import from_expression
from compensator_theory.polynomials._sympy_trees import settled
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import as_symbol, is_operator

_NAME = re.compile(r"(?<![\w.])[^\W\d]\w*")

Value = TypeVar("Value", bound=ExactValue)


Substitutions: TypeAlias = (
    Mapping[str | Symbol, NumberLike] | Iterable[tuple[str | Symbol, NumberLike]] | str | Symbol
)
"""Values for symbols as SymPy takes them: {"a": 2}, [("a", 2), ("b", 1)], or "a" with its value."""


def read_values(values: Substitutions, value: NumberLike | None = None) -> dict[Symbol, Expr]:
    """Read values for symbols, to be substituted simultaneously.

    A list of pairs is applied as in SymPy, one pair after the other.
    """
    if isinstance(values, str | Symbol):
        if value is None:
            raise InputError(f"{repr_of(values)} has no value; write subs({str(values)!r}, 2)")
        pairs: list[Any] = [(values, value)]
    elif value is not None:
        raise InputError(f"{repr_of(values)} is no symbol that has one value; write subs('a', 2)")
    elif isinstance(values, Mapping | sympy.Dict):
        return {as_symbol(name): exact_number(number) for name, number in values.items()}
    elif isinstance(values, list | tuple | sympy.Tuple):
        pairs = list(values)
    else:
        raise InputError(
            f"{repr_of(values)} is no mapping such as {{'a': 2}}, nor a list of pairs, as in "
            "[('a', 2), ('b', 1)]"
        )
    numbers: dict[Symbol, Expr] = {}
    for pair in pairs:
        if not isinstance(pair, list | tuple | sympy.Tuple) or len(pair) != 2:
            raise InputError(
                f"{repr_of(pair)} is no pair of a symbol and its value, as in ('a', 2)"
            )
        symbol, number = as_symbol(pair[0]), exact_number(pair[1])
        numbers = {old: _at(new, {symbol.name: number}) for old, new in numbers.items()}
        numbers.setdefault(symbol, number)
    return numbers


def with_values(
    whole: Value, values: Substitutions, value: NumberLike | None, variable: Symbol
) -> Value:
    """Give values to symbols of a system or a matrix, but not to its variable."""
    numbers = read_values(values, value)
    names = {symbol.name for symbol in numbers}
    if variable.name in names:
        raise InputError(
            f"{variable} is the variable of {whole}; a transfer function is called for a value, "
            "as in G(1), and compose(...) puts another one in its place"
        )
    if value is not None:  # of many, as SymPy has it, those that do not occur change nothing
        require_names(names, names_in(whole) - {variable.name}, whole)
    if any(variable in number.free_symbols for number in numbers.values()):
        raise InputError(f"a value contains {variable}, the variable of {whole}")
    unproven: Any = {"certificate": None} if "certificate" in _fields(whole) else {}
    return substituted(replace(whole, **unproven), numbers)  # type: ignore[type-var,no-any-return]


def require_names(names: Set[str], known: Set[str], whole: object) -> None:
    """Refuse a value for a symbol that does not occur."""
    if unknown := sorted(names - known):
        raise InputError(
            f"{whole} has no symbol {', '.join(unknown)}; its symbols: "
            f"{', '.join(sorted(known)) or 'none'}"
        )


def substituted(argument: Any, values: Mapping[Symbol, Expr]) -> Any:
    """Substitute expressions for symbols in texts, polynomials, matrices, systems or lists."""
    by_name = {symbol.name: value for symbol, value in values.items()}
    return _replaced(argument, by_name) if by_name else argument


def _replaced(value: Any, values: Mapping[str, Expr]) -> Any:
    if isinstance(value, str):
        return _NAME.sub(lambda m: f"({values[m[0]]})" if m[0] in values else m[0], value)
    if isinstance(value, Poly):
        coefficients = [_at(coefficient, values) for coefficient in value.all_coeffs()]
        if any(True for _ in functions_in(coefficients)):
            return polynomial_with_functions(coefficients, value.gen)
        return from_expression(_at(value.as_expr(), values), value.gen)
    if isinstance(value, MatrixBase):
        return value.applyfunc(lambda entry: _at(entry, values))
    if isinstance(value, Expr):
        return _at(value, values)
    if isinstance(value, Basic):
        return value.subs(_of_names(value, values), simultaneous=True)
    if type(value) in (list, tuple):
        return type(value)(_replaced(item, values) for item in value)
    if isinstance(value, dict):
        return {key: _replaced(item, values) for key, item in value.items()}
    if isinstance(value, ExactValue):
        copy: Any = value
        fields = {name: getattr(copy, name) for name in _fields(copy)}
        return replace(copy, **{name: _replaced(part, values) for name, part in fields.items()})
    if str(getattr(value, "dtype", "")) == "object" and hasattr(value, "tolist"):
        return _replaced(value.tolist(), values)  # an array of expressions
    return value


def _fields(value: Any) -> list[str]:
    return [field.name for field in fields(value) if field.init]


def _of_names(value: Basic, values: Mapping[str, Expr]) -> dict[Symbol, Expr]:
    return {s: values[s.name] for s in value.free_symbols if s.name in values}


def _at(expression: Expr, values: Mapping[str, Expr]) -> Expr:
    named = _of_names(expression, values)
    if not named:
        return expression
    top, bottom = (
        settled(side.subs(named, simultaneous=True)) for side in expression.as_numer_denom()
    )
    if bottom == 0:
        where = ", ".join(f"{symbol} = {value}" for symbol, value in named.items())
        raise InputError(f"{expression} does not exist at {where}: it divides by zero there")
    return settled(top / bottom)


def names_in(argument: Any) -> set[str]:
    """Return the names of all symbols in an argument except its variable."""
    if isinstance(argument, str):
        return set(_NAME.findall(argument)) - WORDS
    if isinstance(argument, Poly):
        return {s.name for c in argument.coeffs() for s in c.free_symbols}
    if isinstance(argument, Basic | MatrixBase):
        return {s.name for s in argument.free_symbols}
    if isinstance(argument, dict):
        return names_in(list(argument.values()))
    if type(argument) in (list, tuple):
        return set().union(*map(names_in, argument))
    if isinstance(argument, ExactValue):
        return names_in([getattr(argument, f) for f in _fields(argument) if f != "variable"])
    return set()


def denominators_in(value: Any) -> list[Expr]:
    """Return the denominators of coefficients and entries, polynomials in the symbols."""
    fractions = (sympy.fraction(sympy.cancel(c)) for c in _coefficients(value) if c.free_symbols)
    return [bottom for bottom in dict.fromkeys(b for _, b in fractions) if bottom.free_symbols]


def _coefficients(value: Any) -> Iterator[Expr]:
    if isinstance(value, Poly):
        yield from value.coeffs()
    elif isinstance(value, MatrixBase):
        yield from value
    elif isinstance(value, Expr):
        yield value
    elif type(value) in (list, tuple):
        for part in value:
            yield from _coefficients(part)
    elif isinstance(value, ExactValue):
        for name in _fields(value):
            if name not in ("variable", "certificate"):
                yield from _coefficients(getattr(value, name))


def require_variable(before: Any, after: Any, parameters: Set[str] = frozenset()) -> None:
    """Refuse an argument whose variable dropped out by a substitution; it would be misread.

    Symbols that are known to be parameters are no variable, whatever they are called.
    """
    had = {name for name in names_in(before) - parameters if is_operator(Symbol(name))}
    if had and not had & _remaining_names(after):
        raise InputError(
            f"{', '.join(sorted(had))} drops out of {repr_of(before)}, so that the variable is not "
            "evident; name it, or give a polynomial or transfer function that knows it"
        )


def _remaining_names(argument: Any) -> set[str]:
    if isinstance(argument, str):
        try:
            return {s.name for side in read_text(argument).sides() for s in side.free_symbols}
        except InputError:  # a list of roots, or what its reader refuses
            return names_in(argument)
    if type(argument) in (list, tuple):
        return set().union(*map(_remaining_names, argument))
    return names_in(argument)
