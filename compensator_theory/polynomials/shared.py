"""Several polynomials in one variable."""

from collections.abc import Container, Iterable
from numbers import Number

import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory.polynomials.numbers import exact_number
from compensator_theory.polynomials.poly import PolynomialLike, canonical, polynomial
from compensator_theory.polynomials.variables import Readable, shared_variable


def in_one_variable(
    *objects: PolynomialLike, variable: str | Symbol | None = None, default: str | None = None
) -> tuple[Poly, ...]:
    """Read polynomials that are to be compared, by the rule of :func:`shared_variable`.

    Parameters
    ----------
    *objects : polynomial
        Anything :func:`polynomial` reads; lists show no variable.
    variable : str or Symbol, optional
        The variable; default: evident from all of them together.
    default : str, optional
        What to take where none shows a symbol.

    Raises
    ------
    InputError
        If the variable is not evident, or something is no polynomial.

    Examples
    --------
    >>> from compensator_theory.polynomials.shared import in_one_variable
    >>> in_one_variable("s + 1", [2, "a"])
    (Poly(s + 1, s, domain='QQ'), Poly(2*s + a, s, domain='QQ[a]'))
    """
    if variable is None:
        read = tuple(obj for obj in objects if isinstance(obj, Poly) and _is_read(obj))
        if len(read) == len(objects) and len({obj.gens for obj in read}) == 1:
            return read  # what is read already costs nothing
    parts = [_shown(obj) for obj in objects]
    shows = any(isinstance(part, Poly) or part.free_symbols for part in parts if part is not None)
    if variable is None and default is not None and not shows:
        variable = default
    symbol = shared_variable(parts, variable)
    return tuple(polynomial(obj, symbol) for obj in objects)


def is_list(obj: object) -> bool:
    """Tell whether something lists coefficients.

    Examples
    --------
    >>> from compensator_theory.polynomials.shared import is_list
    >>> is_list([1, 2]), is_list("s + 1")
    (True, False)
    """
    return isinstance(obj, Iterable) and not isinstance(obj, str | Poly | Expr)


def _is_read(poly: Poly) -> bool:
    return len(poly.gens) == 1 and poly.gen.is_Symbol and bool(poly.domain.is_QQ)


def _shown(obj: PolynomialLike) -> Readable:
    if isinstance(obj, Poly):
        return canonical(obj) if len(obj.gens) == 1 else obj.as_expr()
    return None if is_list(obj) else sympy.sympify(exact_number(obj))


def is_one_of(setting: object, allowed: Container[object]) -> bool:
    """Tell whether a setting is among a few words or numbers; a list or an array never is.

    Examples
    --------
    >>> from compensator_theory.polynomials.shared import is_one_of
    >>> is_one_of(-1, (1, -1)), is_one_of([1], (1, -1)), is_one_of(True, (1, -1))
    (True, False, False)
    """
    is_plain = isinstance(setting, str | Number) and not isinstance(setting, bool)
    return is_plain and setting in allowed
