"""Values for symbols, put into whatever a construction takes as an argument."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

from sympy import Basic, Expr, MatrixBase, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials.budget import shown
from compensator_theory.polynomials.expressions import read_text
from compensator_theory.polynomials.poly import from_expression
from compensator_theory.polynomials.sympy_trees import settled
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import is_operator

_NAME = re.compile(r"(?<![\w.])[^\W\d]\w*")

_WORDS = {"sqrt", "CRootOf", "I", "j", "pi"}


def substituted(argument: Any, values: Mapping[Symbol, Expr]) -> Any:
    """Put expressions in the place of symbols in texts, polynomials, matrices, systems or lists.

    Parameters
    ----------
    argument : object
        What a public function takes; what holds no symbols, an int for instance, comes back as it
        is. Symbols are found by their names, as everywhere.
    values : mapping of sympy.Symbol to sympy.Expr
        All at once.
    """
    by_name = {symbol.name: value for symbol, value in values.items()}
    return _replaced(argument, by_name) if by_name else argument


def _replaced(value: Any, values: Mapping[str, Expr]) -> Any:
    if isinstance(value, str):
        return _NAME.sub(lambda m: f"({values[m[0]]})" if m[0] in values else m[0], value)
    if isinstance(value, Poly):
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
        own: Any = value
        given = {name: getattr(own, name) for name in _fields(own)}
        return replace(own, **{name: _replaced(part, values) for name, part in given.items()})
    if str(getattr(value, "dtype", "")) == "object" and hasattr(value, "tolist"):
        return _replaced(value.tolist(), values)  # an array of expressions
    return value


def _fields(value: Any) -> list[str]:
    return [field.name for field in fields(value) if field.init]


def _of_names(value: Basic, values: Mapping[str, Expr]) -> dict[Symbol, Expr]:
    return {s: values[s.name] for s in value.free_symbols if s.name in values}


def _at(expression: Expr, values: Mapping[str, Expr]) -> Expr:
    own = _of_names(expression, values)
    if not own:
        return expression
    top, bottom = (
        settled(side.subs(own, simultaneous=True)) for side in expression.as_numer_denom()
    )
    if bottom == 0:
        where = ", ".join(f"{symbol} = {value}" for symbol, value in own.items())
        raise InputError(f"{expression} does not exist at {where}: it divides by zero there")
    return settled(top / bottom)


def names_in(argument: Any) -> set[str]:
    """Return the names of all symbols in an argument, but of what is written as its variable.

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> from compensator_theory.exceptional_sets.arguments import names_in
    >>> sorted(names_in([transfer_function("1/(s + a)", "s"), "sqrt(2)*b", 3]))
    ['a', 'b']
    """
    if isinstance(argument, str):
        return set(_NAME.findall(argument)) - _WORDS
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


def require_variable(before: Any, after: Any) -> None:
    """Refuse an argument whose variable dropped out with what was put in; it would be misread.

    Examples
    --------
    >>> from compensator_theory.exceptional_sets.arguments import require_variable
    >>> require_variable("1/(a*s + b)", "1/((2)*s + b)")
    """
    had = {name for name in names_in(before) if is_operator(Symbol(name))}
    if had and not had & _names_left(after):
        raise InputError(
            f"{', '.join(sorted(had))} drops out of {shown(before)}, so that the variable is not "
            "evident; name it, or give a polynomial or transfer function that knows it"
        )


def _names_left(argument: Any) -> set[str]:
    if isinstance(argument, str):
        try:
            return {s.name for side in read_text(argument).sides() for s in side.free_symbols}
        except InputError:  # a list of roots, or what its reader refuses
            return names_in(argument)
    if type(argument) in (list, tuple):
        return set().union(*map(_names_left, argument))
    return names_in(argument)
