"""Arithmetic of quotients of polynomials that never cancels what they share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Self, TypeAlias, cast

import sympy
from sympy import Expr, Poly, Rational, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials.budget import ask
from compensator_theory.polynomials.expressions import read_text
from compensator_theory.polynomials.numbers import NumberLike, exact_number
from compensator_theory.polynomials.poly import canonical, sides_in
from compensator_theory.polynomials.quotients import Quotient, multiplied_out
from compensator_theory.polynomials.reading import polynomial
from compensator_theory.polynomials.sympy_trees import tree_of
from compensator_theory.polynomials.variables import require_no_other_operator
from compensator_theory.transfer_functions.sample_times import shared_sample_time

Sides: TypeAlias = tuple[Poly, Poly]
Operand: TypeAlias = "QuotientArithmetic | NumberLike | Poly"
"""What stands beside a transfer function in a sum or a product."""


class QuotientArithmetic:
    """The operators + - * / ** of a class with numerator and denominator.

    The rules are those of a text: a sum over one denominator keeps it, a sum over two different
    ones is over their product, a product multiplies numerators and denominators, and nothing
    cancels. So G - G is 0 over the denominator of G, and G/G is N D over D N. A sample time is
    kept, and two different ones are refused.

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> G = transfer_function("1/(s + 1)")
    >>> print(G + 2, G * G, G**-2 / "s + a", sep=", ")
    (2*s + 3)/(s + 1), (1)/(s**2 + 2*s + 1), (s**2 + 2*s + 1)/(s + a)
    """

    numerator: Poly
    denominator: Poly

    sample_time: Rational | None

    def __init__(
        self, numerator: Poly, denominator: Poly, *, sample_time: Rational | None = None
    ) -> None:
        """Every class that derives from this one is made of these."""
        raise NotImplementedError

    __array_ufunc__ = None  # an array of numbers times a transfer function is refused, not looped

    def __add__(self, other: Operand) -> Self:
        return self._join(other, added)

    __radd__ = __add__

    def __sub__(self, other: Operand) -> Self:
        return self._join(other, lambda a, b: added(a, (-b[0], b[1])))

    def __rsub__(self, other: Operand) -> Self:
        return self._join(other, lambda a, b: added(b, (-a[0], a[1])))

    def __neg__(self) -> Self:
        return type(self)(-self.numerator, self.denominator, sample_time=self.sample_time)

    def __pos__(self) -> Self:
        return self

    def __mul__(self, other: Operand) -> Self:
        return self._join(other, multiplied)

    __rmul__ = __mul__

    def __truediv__(self, other: Operand) -> Self:
        return self._join(other, lambda a, b: multiplied(a, inverted(b)))

    def __rtruediv__(self, other: Operand) -> Self:
        return self._join(other, lambda a, b: multiplied(b, inverted(a)))

    def __pow__(self, exponent: int) -> Self:
        if isinstance(exponent, bool) or not isinstance(exponent, int):
            raise TypeError(f"{exponent!r} is no exponent of a transfer function; an int is")
        sides = self.numerator, self.denominator
        top, bottom = inverted(sides) if exponent < 0 else sides
        for side in (top, bottom):
            ask("degree", max(0, int(side.total_degree())) * abs(exponent), "the power")
        return type(self)(
            canonical(top ** abs(exponent)),
            canonical(bottom ** abs(exponent)),
            sample_time=self.sample_time,
        )

    def _join(self, other: Operand, operation: Callable[[Sides, Sides], Sides]) -> Self:
        sides = sides_of(other, self.denominator.gen)
        if sides is None:
            return cast(Self, NotImplemented)  # Python then asks the other operand
        joined = operation((self.numerator, self.denominator), sides)
        return type(self)(*joined, sample_time=shared_sample_time(self, other))


def sides_of(operand: Operand, variable: Symbol) -> Sides | None:
    """Return numerator and denominator of an operand; None if it is none.

    Raises
    ------
    InputError
        If it is a transfer function in another variable, or no quotient of polynomials.

    Examples
    --------
    >>> from sympy.abc import s
    >>> from compensator_theory.transfer_functions.arithmetic import sides_of
    >>> sides_of("2/(s + 1)", s)
    (Poly(2, s, domain='QQ'), Poly(s + 1, s, domain='QQ'))
    """
    if isinstance(operand, QuotientArithmetic):
        if operand.denominator.gen != variable:
            raise InputError(
                f"{operand} is in {operand.denominator.gen} and the other operand in {variable}; "
                "both need one variable"
            )
        return operand.numerator, operand.denominator
    if isinstance(operand, Poly):
        return polynomial(operand, variable), constant_one(polynomial(operand, variable))
    if isinstance(operand, str):
        return _in_one_operator(sides_in(read_text(operand), variable))
    try:
        number = exact_number(operand)
    except InputError:
        if isinstance(operand, Expr | int | float | complex):
            raise  # a NaN, for instance: the reason is better than "unsupported operand"
        return None
    return _in_one_operator(sides_in(quotient_of(number), variable))


def added(a: Sides, b: Sides) -> Sides:
    """Add two quotients over the denominator they share, else over the product of both.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.transfer_functions.arithmetic import added
    >>> added((polynomial("s"), polynomial("s + 1")), (polynomial("1", "s"), polynomial("s + 1")))
    (Poly(s + 1, s, domain='QQ'), Poly(s + 1, s, domain='QQ'))
    """
    if a[1] == b[1]:
        return canonical(a[0] + b[0]), a[1]
    (n_1, d_2), (n_2, d_1) = (a[0], b[1]), (b[0], a[1])
    return canonical(product(n_1, d_2) + product(n_2, d_1)), product(d_1, d_2)


def multiplied(a: Sides, b: Sides) -> Sides:
    """Multiply two quotients, side by side.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.transfer_functions.arithmetic import multiplied
    >>> multiplied((polynomial("s"), polynomial("s + 1")), (polynomial("s + 1"), polynomial("s")))
    (Poly(s**2 + s, s, domain='QQ'), Poly(s**2 + s, s, domain='QQ'))
    """
    return product(a[0], b[0]), product(a[1], b[1])


def inverted(sides: Sides) -> Sides:
    """Exchange numerator and denominator.

    Raises
    ------
    InputError
        If the numerator is zero.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.transfer_functions.arithmetic import inverted
    >>> inverted((polynomial("s"), polynomial("s + 1")))[0]
    Poly(s + 1, s, domain='QQ')
    """
    if sides[0].is_zero:
        raise InputError("the transfer function 0 has no inverse")
    return sides[1], sides[0]


def product(a: Poly, b: Poly) -> Poly:
    """Multiply two polynomials, whose degrees together must be within the budget.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.transfer_functions.arithmetic import product
    >>> product(polynomial("s + 1"), polynomial("s - a", "s"))
    Poly(s**2 + (1 - a)*s - a, s, domain='QQ[a]')
    """
    if not (a.is_zero or b.is_zero):
        ask("degree", int(a.degree()) + int(b.degree()), "the product")
    return canonical(a * b)


def constant_one(like: Poly) -> Poly:
    """Return 1 as a polynomial in the same variable.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.transfer_functions.arithmetic import constant_one
    >>> constant_one(polynomial("s + a", "s"))
    Poly(1, s, domain='QQ')
    """
    return Poly(1, like.gen, domain=sympy.QQ)


def quotient_of(expression: Expr) -> Quotient:
    """Multiply out a SymPy expression, as SymPy has it.

    Examples
    --------
    >>> from sympy.abc import s
    >>> from compensator_theory.transfer_functions.arithmetic import quotient_of
    >>> quotient_of(1/s + 1/(s + 1)).sides()
    (2*s + 1, s**2 + s)
    """
    return multiplied_out(tree_of(expression), least_denominators=True)


def _in_one_operator(sides: Sides) -> Sides:
    """Refuse z or q as a symbol of the coefficients of what is in s, and the reverse."""
    for side in sides:
        require_no_other_operator(side)
    return sides
