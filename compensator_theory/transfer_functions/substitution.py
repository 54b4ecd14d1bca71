"""What becomes of a transfer function when its variable or its symbols get values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials.budget import ask, shown
from compensator_theory.polynomials.expressions import read_text
from compensator_theory.polynomials.numbers import NumberLike, exact_number
from compensator_theory.polynomials.poly import canonical, from_coefficients
from compensator_theory.polynomials.variables import as_symbol, evident_variable
from compensator_theory.transfer_functions.arithmetic import (
    Operand,
    QuotientArithmetic,
    Sides,
    constant_one,
    quotient_of,
    sides_of,
)


class Substitution(QuotientArithmetic):
    """Values, parameters and compositions of a class with numerator and denominator.

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> G = transfer_function("1/(s + a)", "s")
    >>> print(G(1), G.subs({"a": 2}), G.subs({"a": 1}).compose("(z - 1)/(z + 1)"), sep=", ")
    1/(a + 1), (1)/(s + 2), (z/2 + 1/2)/(z)
    """

    def __call__(self, point: NumberLike) -> Expr:
        r"""Return the value at a number or a symbolic point, G(1), G(2j) or G("exp(1)").

        Raises
        ------
        InputError
            If the point is a root of the denominator.
        """
        at = exact_number(point)
        top, bottom = (
            _expanded(side.as_expr().subs(side.gen, at))
            for side in (self.numerator, self.denominator)
        )
        if bottom == 0:
            what = "a root that numerator and denominator share; take .reduced()" if top == 0 else (
                "a pole"
            )  # fmt: skip
            raise InputError(f"{self} has no value at {self.denominator.gen} = {at}: it is {what}")
        return quotient_of(top / bottom).value()

    def subs(self, values: Mapping[str | Symbol, NumberLike]) -> Self:
        """Give values, numbers or expressions, to symbols of the coefficients, all at once.

        Raises
        ------
        InputError
            If a coefficient has no value there, a name is that of the variable (`compose` is for
            that), or a symbol does not occur.
        """
        if not isinstance(values, Mapping):
            raise InputError(f"subs takes a mapping such as {{'a': 2}}, not {shown(values)}")
        given = {as_symbol(name): exact_number(value) for name, value in values.items()}
        variable = self.denominator.gen
        names = {
            s.name: s for side in (self.numerator, self.denominator) for s in side.free_symbols
        }
        if unknown := sorted(symbol.name for symbol in given if symbol.name not in names):
            known = ", ".join(sorted(set(names) - {variable.name})) or "none"
            raise InputError(f"{self} has no symbol {', '.join(unknown)}; its symbols: {known}")
        if variable.name in {symbol.name for symbol in given}:
            raise InputError(
                f"{variable} is the variable of {self}; call it for a value, as in G(1), and "
                "compose(...) it with another transfer function"
            )
        replaced = {names[symbol.name]: value for symbol, value in given.items()}
        if any(variable in value.free_symbols for value in replaced.values()):
            raise InputError(f"a value contains {variable}, the variable of {self}")
        return type(self)(*(
            from_coefficients([_at(c, replaced, self) for c in side.all_coeffs()], variable)
            for side in (self.numerator, self.denominator)
        ), sample_time=self.sample_time)  # fmt: skip

    def compose(self, inner: Operand, variable: str | Symbol | None = None) -> Self:
        r"""Put a transfer function in the place of the variable, for instance Tustin's.

        .. math:: G\Big(\frac{p}{q}\Big) = \frac{\sum_k N_k p^k q^{d-k}}{\sum_k D_k p^k q^{d-k}},
                  \qquad d = \max(\deg N, \deg D)

        Parameters
        ----------
        inner : transfer function, str, expression or number
            In its own variable, which is that of the result.
        variable : str or Symbol, optional
            The variable of `inner` where it does not show it.

        Raises
        ------
        InputError
            If the denominator becomes zero.
        """
        top, bottom = _inner(inner, self.denominator.gen, variable)
        d = max(self.numerator.degree(), self.denominator.degree())
        ask("degree", int(d) * max(1, int(top.degree()), int(bottom.degree())), "the composition")
        powers = [(constant_one(top), constant_one(top))]
        for _ in range(int(d)):
            powers.append((powers[-1][0] * top, powers[-1][1] * bottom))
        sides = []
        for side in (self.numerator, self.denominator):
            terms = [
                powers[k][0] * powers[int(d) - k][1] * Poly(c, top.gen) for (k,), c in side.terms()
            ]
            sides.append(canonical(sum(terms, start=Poly(0, top.gen))))
        if sides[1].is_zero:
            raise InputError(f"{self} has no value there: its denominator becomes zero")
        period = self.sample_time if top.gen == self.denominator.gen else None
        period = getattr(inner, "sample_time", None) or period
        return type(self)(*sides, sample_time=period)


def _inner(inner: Operand, outer: Symbol, variable: str | Symbol | None) -> Sides:
    if isinstance(inner, QuotientArithmetic | Poly):
        own = inner.gen if isinstance(inner, Poly) else inner.denominator.gen
    else:
        read = read_text(inner) if isinstance(inner, str) else quotient_of(exact_number(inner))
        occurring = read.value().free_symbols
        own = evident_variable(occurring, repr(inner)) if occurring else outer
    found = sides_of(inner, own if variable is None else as_symbol(variable))
    if found is None:
        raise InputError(f"{shown(inner)} cannot stand in the place of {outer}")
    return found


def _at(coefficient: Expr, values: dict[Symbol, Expr], whole: object) -> Expr:
    found = sympy.sympify(coefficient).subs(values, simultaneous=True)
    if found.has(sympy.zoo, sympy.nan, sympy.oo):
        at = ", ".join(f"{name} = {value}" for name, value in values.items())
        raise InputError(
            f"{whole} does not exist at {at}: the coefficient {coefficient} divides by zero there"
        )
    return found


def _expanded(expression: Expr) -> Expr:
    return quotient_of(sympy.expand(expression)).value()
