"""Canonical text of an input, which reads back to the same number, polynomial or system."""

from __future__ import annotations

import flint
import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.libraries import roots_in_sympy
from compensator_theory.polynomials._algebraic import Algebraic, algebraic, rational_number
from compensator_theory.polynomials._budget import unlimited
from compensator_theory.polynomials._expressions import read_text
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._polynomial_objects import in_our_order
from compensator_theory.polynomials._quotients import Product, Quotient, multiplied_out
from compensator_theory.polynomials._reading import is_list, polynomial, read_quotient
from compensator_theory.polynomials._sympy_trees import tree_of
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._foreign import is_foreign


@roots_in_sympy()
def canonical(obj: TransferFunctionLike, variable: str | Symbol | None = None) -> str:
    """Return the canonical text of a number, polynomial or transfer function.

    Parameters
    ----------
    obj : number, polynomial or transfer function
        Anything that :func:`exact_number`, :func:`polynomial` or :func:`transfer_function` reads.
        A list holds coefficients.
    variable : str or Symbol, optional
        As for these.

    Returns
    -------
    str
        Reads back to the same, and is its own canonical form. A transfer function that has a
        denominator is written ``(N)/(D)``, its common factors kept.

    Raises
    ------
    InputError
        If it cannot be read, or is a number that no text here stands for.

    Examples
    --------
    >>> from compensator_theory import canonical
    >>> canonical("2i + .50"), canonical("(s+1)*(s+2)"), canonical("1/s + 1/(s + 1)")
    ('1/2 + 2*I', 's**2 + 3*s + 2', '(2*s + 1)/(s**2 + s)')
    """
    first, is_plain = _written(obj, variable)
    is_text = is_plain or (isinstance(obj, str) and variable is None)
    written = first
    for _ in range(5):  # SymPy has several forms for roots of rational numbers
        with unlimited():
            quotient = read_text(written)
            again = "" if is_text else _form(written, quotient, variable)[0]
        if is_text:  # within the budget, as its reader will look at it: q/q - s is no system, -s is
            again, _ = _form(written, quotient, variable)
        if again == written:
            return written
        if len(again) > 2 * len(written) > 4 * len(first):  # each pass brings in new products
            break
        written = again
    if (whole := _with_whole_coefficients(obj, variable)) is not None:
        return whole
    raise InputError(f"{first[:60]} has no text that reads back to it; write symbols")


def _written(obj: TransferFunctionLike, variable: str | Symbol | None) -> tuple[str, bool]:
    """Return the text of one pass, and whether it is final."""
    obj = in_our_order(obj)
    is_nested = isinstance(obj, list) and isinstance(next(iter(obj), None), list | tuple)
    if isinstance(obj, ExactValue | tuple) or is_nested or is_foreign(obj):
        return str(transfer_function(obj, variable)), False
    if isinstance(obj, Poly) or is_list(obj):
        return format_polynomial(polynomial(obj, variable)), False
    return _form(obj, read_quotient(obj), variable)


def _form(
    obj: TransferFunctionLike, quotient: Quotient, variable: str | Symbol | None
) -> tuple[str, bool]:
    """Write a quotient that was read."""
    top, bottom = quotient.sides()
    if top.is_number and bottom.is_number:
        return _number(quotient.value()), False
    try:
        if not bottom.is_number:
            read = (
                quotient if quotient.is_plain else obj
            )  # other input may have functions of symbols
            return str(transfer_function(read, variable)), False
        return format_polynomial(polynomial(quotient.value(), variable)), False
    except InputError:
        if variable is not None:
            raise
    return _plain(quotient), True


def _with_whole_coefficients(
    obj: TransferFunctionLike, variable: str | Symbol | None
) -> str | None:
    """Write a system without inner fractions, for a monic form that is too long.

    Its coefficients are divided by sums with roots of symbols, or by powers of symbols: here they
    are multiplied by their denominators, and their common factor is divided out.
    """
    written, known = "", obj
    for _ in range(5):
        with unlimited():
            try:
                system = transfer_function(known, variable)
            except InputError:  # a number, which has several forms in SymPy
                return None
            if isinstance(known, str):
                quotient = read_text(known)
            else:
                tree = Product(
                    (tree_of(system.numerator.as_expr()),),
                    (tree_of(system.denominator.as_expr()),),
                )
                quotient = multiplied_out(tree, least_denominators=True)
            top, bottom = _without_shared_content(quotient, system.variable).sides()
        written, before = f"({text(top)})/({text(bottom)})", written
        if written == before:
            return written
        known = written
    return None


def _without_shared_content(quotient: Quotient, variable: Symbol) -> Quotient:
    """Divide both sides by the gcd of their coefficients as polynomials in the variable."""
    if variable not in quotient.generators:
        return quotient
    place = quotient.generators.index(variable)
    shared = quotient.numerator * 0
    for side in (quotient.numerator, quotient.denominator):
        coefficients: dict[int, dict[tuple[int, ...], flint.fmpq]] = {}
        for powers, c in side.to_dict().items():
            rest = (*powers[:place], 0, *powers[place + 1 :])
            coefficients.setdefault(powers[place], {})[rest] = c
        for terms in coefficients.values():
            shared = shared.gcd(side.context().from_dict(terms))
    shared *= (quotient.denominator / shared).leading_coefficient()
    return Quotient(quotient.numerator / shared, quotient.denominator / shared, quotient.generators)


def _plain(quotient: Quotient) -> str:
    return text(quotient.value())


def _number(value: Expr) -> str:
    """Write a constant; roots of unity and cosines by their real and imaginary parts."""
    if value.atoms(sympy.exp, sympy.cos, sympy.sin) or _has_branches(value):
        number = algebraic(value)
        if number is not None:
            value = _in_parts(number)
        elif value.atoms(sympy.exp, sympy.cos, sympy.sin):
            raise InputError(f"the number {text(value)[:60]} has no exact text; write a symbol")
    if value.atoms(sympy.NumberSymbol) - {sympy.pi}:
        raise InputError(f"{text(value)[:60]} would read back as a symbol; write one in its place")
    written = text(value)
    with unlimited():
        read_text(written)
    return written


def _has_branches(value: Expr) -> bool:
    powers = [p for p in value.atoms(sympy.Pow) if not p.exp.is_Integer]
    return any(p.exp.q % 2 and p.base.is_Rational and p.base < 0 for p in powers)


def _in_parts(number: Algebraic) -> Expr:
    half, minus = rational_number(sympy.S.Half), rational_number(sympy.Integer(-1))
    real = ((number + number.conjugate) * half).expression()
    if number.is_real:
        return number.expression()
    unit = algebraic(-sympy.I / 2)
    assert unit is not None
    imaginary = ((number + minus * number.conjugate) * unit).expression()
    return real + sympy.I * imaginary
