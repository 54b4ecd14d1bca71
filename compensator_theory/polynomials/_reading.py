"""Reading polynomials: one, or several in one variable, from text, expressions and lists."""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from numbers import Number
from typing import Any, Protocol, TypeAlias, cast

import sympy
from sympy import Expr, Poly, Symbol, Tuple

from compensator_theory.errors import InputError
from compensator_theory.libraries import roots_in_sympy
from compensator_theory.polynomials._budget import is_array, is_collection, quoted
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._expressions import read_text
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike, exact_number, read_coefficients
from compensator_theory.polynomials._poly import (
    canonical,
    from_coefficients,
    from_expression,
    from_quotient,
)
from compensator_theory.polynomials._polynomial_objects import in_our_order
from compensator_theory.polynomials._quotients import Quotient, multiplied_out
from compensator_theory.polynomials._sympy_trees import tree_of
from compensator_theory.polynomials._variables import (
    NAME_THE_VARIABLE,
    Readable,
    Time,
    agreed_time,
    as_symbol,
    shared_variable,
    variable_in,
)

PolynomialLike: TypeAlias = Poly | NumberLike | Sequence[NumberLike]
"""Input types of :func:`polynomial`."""


@holds_where_defined
@roots_in_sympy()
@carrying()
def polynomial(obj: PolynomialLike, variable: str | Symbol | None = None) -> Poly:
    r"""Make an exact polynomial with coefficients in descending powers.

    .. math:: a(s) = a_k s^k + a_{k-1} s^{k-1} + \cdots + a_0

    Parameters
    ----------
    obj : Poly, Expr, str, number or sequence
        A list, tuple or one-dimensional array lists :math:`a_k, \ldots, a_0`; leading zeros are
        dropped. NumPy's `Polynomial` and the polynomials of python-flint, which list them from
        :math:`a_0` on, are read in that order, its `poly1d` and SymPy's in theirs.
    variable : str or Symbol, optional
        Default: the only one of ``s``, ``z``, ``q`` that occurs, else the only symbol.

    Returns
    -------
    sympy.Poly
        Over QQ for rational coefficients, over QQ[a, b] for symbols. Symbols stand for real
        numbers.

    Raises
    ------
    InputError
        If the variable is not evident, or `obj` is no polynomial with real coefficients in it.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> polynomial("(s + 1)*(s + 0.5)")
    Poly(s**2 + 3/2*s + 1/2, s, domain='QQ')
    >>> polynomial([1, "a", 0.25], "q")
    Poly(q**2 + a*q + 1/4, q, domain='QQ[a]')
    """
    read = read_once(obj)
    if isinstance(read, Poly):
        return _from_poly(read, variable)
    if isinstance(read, Quotient):
        reduced = read.reduced()
        return from_quotient(reduced, shared_variable([_as_readable(reduced)], variable))
    if isinstance(read, Expr):
        symbol = shared_variable([read], variable)
        return from_quotient(multiplied_out(tree_of(read), least_denominators=True), symbol)
    if not is_list(read):
        raise InputError(
            f"a {type(read).__name__} does not say which is its first and which its last "
            "coefficient; list them from the highest power down, as in [1, 3, 2]"
        )
    coefficients = read_coefficients(cast(Iterable[NumberLike], read))
    if variable is None:
        raise InputError(
            f"the variable of a list of {len(coefficients)} coefficients is not evident; ",
            *NAME_THE_VARIABLE,
        )
    symbol = as_symbol(variable)
    if any(symbol in value.free_symbols for value in coefficients):
        raise InputError(f"a coefficient in the list contains the variable {symbol} itself")
    return from_coefficients(coefficients, symbol)


def read_once(obj: Any) -> Any:
    """Read a text or an expression, before its variable is known.

    Return a Poly, the Quotient of a text, an Expr, or a list of coefficients unchanged.
    """
    obj = in_our_order(obj)
    if isinstance(obj, Poly | Quotient):
        return obj
    if isinstance(obj, str):
        return read_text(obj)
    if is_collection(obj) or hasattr(obj, "__iter__"):
        return obj
    return sympy.sympify(exact_number(obj))


def read_quotient(obj: Any) -> Quotient:
    """Read a text as it is written, and any other expression or number as SymPy has it."""
    if isinstance(obj, Quotient):
        return obj
    if isinstance(obj, str):
        return read_text(obj)
    return multiplied_out(tree_of(exact_number(obj)), least_denominators=True)


def read_plain_text(obj: Any) -> Any:
    """Read a text of symbols and rational numbers; return other input unchanged.

    What else a text holds, functions of symbols for instance, is carried by whoever reads it.
    """
    if not isinstance(obj, str):
        return obj
    quotient = read_text(obj)
    return quotient if quotient.is_plain else obj


class HasCharacteristicPolynomial(Protocol):
    """A system of this package, with its characteristic polynomial."""

    @property
    def characteristic_polynomial(self) -> Poly:
        """Return the polynomial whose roots are the poles, hidden ones counted."""
        ...


PolynomialOrSystem: TypeAlias = PolynomialLike | HasCharacteristicPolynomial


def polynomial_in_time(
    obj: PolynomialOrSystem,
    time: object,
    variable: str | Symbol | None = None,
) -> tuple[Poly, Time]:
    """Read a polynomial and its time domain, from s, z or q, or else from `time`."""
    system = getattr(obj, "realisation", obj)  # of a sampled plant, a minimal realisation
    if (poles := getattr(system, "characteristic_polynomial", None)) is not None:
        obj = poles
    elif hasattr(obj, "poles") or hasattr(obj, "to_control"):
        raise InputError(
            f"a {type(obj).__name__} is a system, not a polynomial; give transfer_function(system) "
            "or realisation(system), for its poles"
        )
    elif _holds_matrices(obj):
        raise InputError(
            f"{quoted(obj)} is no polynomial; of (A, B, C) give realisation((A, B, C), 's'), and "
            "of a square matrix sympy.Matrix(A).charpoly('s')"
        )
    obj = in_our_order(obj)
    if variable is None and time is not None and is_list(obj):
        variable = variable_in(time, None, "the polynomial")
    poly = polynomial(obj, variable)
    return poly, agreed_time(time, poly.gen)


def in_one_variable(
    *objects: PolynomialLike, variable: str | Symbol | None = None, default: str | None = None
) -> tuple[Poly, ...]:
    """Read polynomials that are to be compared, by the rule of :func:`shared_variable`."""
    if variable is not None:
        symbol = as_symbol(variable)
        return tuple(polynomial(obj, symbol) for obj in objects)
    read = tuple(obj for obj in objects if isinstance(obj, Poly) and _shows_variable(obj))
    if len(read) == len(objects) and len({obj.gens for obj in read}) == 1:
        return tuple(map(canonical, read))  # objects that are read already cost next to nothing
    readings = [*map(_reading, objects)]
    parts = [part for part, _ in readings]
    shows = any(isinstance(part, Poly) or part.free_symbols for part in parts if part is not None)
    symbol = shared_variable(parts, None if shows else default)
    return tuple(polynomial(obj, symbol) for _, obj in readings)


def is_list(obj: object) -> bool:
    """Tell whether something lists coefficients from the highest power down.

    Not everything that can be iterated does: polynomials of other packages begin with the constant.
    """
    listed = isinstance(obj, Sequence | Tuple) and is_collection(obj)
    return listed or is_array(obj, dimensions=1)


def _holds_matrices(obj: object) -> bool:
    nested = isinstance(obj, list | tuple) and any(isinstance(part, list | tuple) for part in obj)
    return nested or len(getattr(obj, "shape", ())) == 2


def _shows_variable(poly: Poly) -> bool:
    return len(poly.gens) == 1 and bool(poly.gen.is_Symbol)


def _reading(obj: PolynomialLike) -> tuple[Readable, Any]:
    """Return the part of an argument that names the variable, and the argument as read."""
    read = read_once(obj)
    if isinstance(read, Poly):
        return (canonical(read) if len(read.gens) == 1 else read.as_expr()), obj
    if isinstance(read, Quotient):
        reduced = read.reduced()
        return _as_readable(
            reduced
        ), reduced if reduced.is_plain else obj  # other input may have functions of symbols
    return (read if isinstance(read, Expr) else None), obj


def _as_readable(reduced: Quotient) -> Readable:
    return reduced if reduced.is_plain else reduced.value()


def _from_poly(poly: Poly, variable: str | Symbol | None) -> Poly:
    if len(poly.gens) > 1 and variable is not None:
        return from_expression(exact_number(poly.as_expr()), as_symbol(variable))
    poly = canonical(poly)
    if variable is None or poly.gen == (symbol := as_symbol(variable)):
        return poly
    if poly.degree() > 0:
        raise InputError(f"{quoted(poly)} is a polynomial in {poly.gen}, not in {variable}")
    return from_expression(poly.as_expr(), symbol)


def is_one_of(setting: object, allowed: Container[object]) -> bool:
    """Return whether a setting is one of a few words or numbers; a list or array never is."""
    is_plain = isinstance(setting, str | Number) and not isinstance(setting, bool)
    return is_plain and setting in allowed
