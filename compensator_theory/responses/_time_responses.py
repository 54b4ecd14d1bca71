"""Inverse Laplace and z-transforms of rational functions, as sums over the poles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import factorial
from typing import Any, ClassVar, TypeAlias

import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory import figures
from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory._showing import picture_of
from compensator_theory.errors import ImproperError, InputError, NoSolutionError
from compensator_theory.forms._expansions import markov_parameters, partial_fractions
from compensator_theory.matrices._certificates import Certified, Residuals
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._quotients_modulo import product_modulo, quotient_modulo
from compensator_theory.polynomials._budget import limit_of
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._letters import fresh, names_in_all
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import canonical, over_coefficient_field
from compensator_theory.polynomials._substitution import denominators_in
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.responses._modes import Mode
from compensator_theory.responses._step_characteristics import StepCharacteristics
from compensator_theory.roots._stability import decide_stability
from compensator_theory.systems._transfer_functions import TransferFunction

Series: TypeAlias = list[Poly]
"""Coefficients of a power series about a root r, polynomials in r modulo its irreducible factor."""


@dataclass(frozen=True)
class TimeResponse(StepCharacteristics, Certified, ExactValue):
    r"""A signal of which the transform is rational, in closed form.

    .. math:: y(t) = \mathcal L^{-1} Y, \quad t \ge 0, \qquad\text{or}\qquad
              y(k) = \mathcal Z^{-1} Y, \quad k = 0, 1, 2, \ldots

    Attributes
    ----------
    transform : TransferFunction
        Y, without common factors and without the dead time.
    impulses : sympy.Poly
        Of continuous time: the polynomial part of Y, whose coefficient of s^i belongs to the i-th
        derivative of the Dirac impulse at t = 0. Otherwise 0.
    terms : tuple of Mode
        The contributions of the irreducible factors of the denominator (of z**-1 Y in discrete
        time, whose factor z has the first samples).
    time : sympy.Symbol
        t in continuous time, k in discrete time.
    delay : sympy.Expr
        The dead time in s, before which the response is 0; impulses come at its end.

    Examples
    --------
    >>> from compensator_theory import step_response
    >>> y = step_response("2/(s**2 + 2*s + 5)")
    >>> print(y)
    y(t) = 2/5 - exp(-t)*sin(2*t)/5 - 2*exp(-t)*cos(2*t)/5
    >>> y.is_verified, y.final_value, y("pi")
    (True, 2/5, 2/5 - 2*exp(-pi)/5)
    >>> y.overshoot(), y.settling_time("0.05")
    (0.2078795763510 ± 3.2e-13, 2.345239352229 ± 1.8e-12)
    """

    identity: ClassVar[str] = "the transform of the response = Y"

    transform: TransferFunction
    impulses: Poly
    terms: tuple[Mode, ...]
    time: Symbol
    delay: Expr = sympy.S.Zero

    @property
    def variable(self) -> Symbol:
        """Variable of the transform."""
        return self.transform.variable

    @property
    def is_discrete(self) -> bool:
        """Whether the response is a sequence."""
        return self.transform.time == "discrete"

    @cached_property
    def expression(self) -> Expr:
        """The response for t > 0 or k >= 0; impulses at t = 0 are Dirac's and its derivatives.

        With a dead time, a Heaviside function makes it 0 before.
        """
        since = self.time - self.delay
        signal = self._after_delay
        if self.delay != 0:
            signal = signal.subs(self.time, since) * sympy.Heaviside(since)
        impulses = [
            c * sympy.DiracDelta(since, *([power] if power else []))
            for (power,), c in self.impulses.terms()
            if c != 0
        ]
        return sympy.Add(signal, *impulses)

    @cached_property
    def _after_delay(self) -> Expr:
        """The response without impulses, as a function of the time since the dead time."""
        parts = (m.expression(self.time, is_discrete=self.is_discrete) for m in self.terms)
        return sympy.Add(*parts)

    @property
    def exceptional(self) -> tuple[Expr, ...]:
        """Polynomials in the symbols at whose zeros the closed form is another, poles that meet."""
        parts = [c for mode in self.terms for c in mode.coefficients]
        divisors = denominators_in([*parts, *(mode.factor for mode in self.terms)])
        if self.is_discrete:  # r^(k-j+1) is written as r^k r^(1-j)
            divisors += [m.factor.TC() for m in self.terms if len(m.coefficients) > 1]
        return exceptional_factors(divisors)

    @property
    def initial_value(self) -> Expr:
        """The value at t = 0+ or k = 0, from the transform: lim s Y(s), or Y at infinity.

        Raises
        ------
        ImproperError
            If Y has impulses, so that there is no value at 0+ of the polynomial part.
        """
        if self.delay != 0:
            return sympy.Integer(0)
        Y = self.transform
        if Y.numerator.is_zero:
            return sympy.Integer(0)
        excess = Y.order - max(0, int(Y.numerator.degree()))
        if self.is_discrete:
            return Y.numerator.LC() if excess == 0 else sympy.Integer(0)
        rest = Y.numerator.rem(Y.denominator)
        return rest.coeff_monomial(Y.variable ** (Y.order - 1)) if Y.order else sympy.Integer(0)

    @property
    def final_value(self) -> Expr:
        """The value for t or k towards infinity; with symbols, where the other poles are stable.

        Raises
        ------
        NoSolutionError
            If a pole of a rational Y keeps the response from settling.
        """
        origin = Poly([1, -1] if self.is_discrete else [1, 0], self.variable, domain="QQ")
        value = sympy.Integer(0)
        for mode in self.terms:
            p = mode.factor
            if p == origin and len(mode.coefficients) == 1:
                value = mode.coefficients[0].as_expr()
            elif p.free_symbols_in_domain or decide_stability(p):
                continue
            else:
                raise NoSolutionError(
                    f"{self.transform} has no final value: its poles at the roots of "
                    f"{format_polynomial(p)} do not decay"
                )
        return value

    def __call__(self, time: NumberLike) -> Expr:
        """Return the exact value at a time in seconds, or at a step.

        In discrete time up to the step that the budget allows as a degree, it is the coefficient
        of the expansion of Y at infinity, otherwise the closed form.
        """
        at = exact_number(time)
        if self.is_discrete and not (at.is_Integer or at.free_symbols):
            raise InputError(f"{at} is no step of a response in discrete time; give an integer")
        if at.is_negative:
            return sympy.Integer(0)
        if self.is_discrete and at.is_Integer and at <= limit_of("degree"):
            return markov_parameters(self.transform, int(at) + 1)[-1]
        since = at - self.delay
        if since.is_negative:
            return sympy.Integer(0)
        if since.is_number and self.impulses.is_zero:
            return self._after_delay.subs(self.time, since)
        return self.expression.subs(self.time, at)

    def plot(self, until: NumberLike | None = None, **options: Any) -> figures.Figure:
        """Draw the response, its final value, its overshoot and where it settles within 2 %.

        Parameters
        ----------
        until : number, optional
            The last time in seconds, or step. Default: 1.5 settling times; where the response does
            not settle, some periods or its growth by a factor of 20.
        ax : matplotlib Axes, optional
            Where it is drawn instead of in a new figure.
        width : float
            Of the figure in inches.

        Returns
        -------
        matplotlib.figure.Figure
            Not attached to a window.

        Raises
        ------
        InputError
            If the response has symbols, or `until` is not positive.

        Examples
        --------
        >>> from compensator_theory import step_response
        >>> figure = step_response("1/(s**2 + s + 1)").plot()
        >>> figure.axes[0].get_title()
        '$y(t)$: settles in 8.08 s, overshoot 16.3 %'
        """
        return picture_of(self, until=until, **options)

    def _residuals(self) -> Residuals:
        numerator, denominator = self.impulses, Poly(1, self.variable, domain="QQ")
        factor = Poly(self.variable if self.is_discrete else 1, self.variable, domain="QQ")
        for mode in self.terms:
            top, bottom = mode.transform
            numerator = numerator * bottom + top * factor * denominator
            denominator = denominator * bottom
        Y = self.transform
        return [canonical(numerator * Y.denominator - Y.numerator * denominator)]

    def __str__(self) -> str:
        name = f"y({self.time})"
        return f"{name} = {text(self.expression)}"

    def _repr_latex_(self) -> str:
        return displayed(rf"y({self.time}) = {latex(self.expression)}")


def inverse_transform(Y: TransferFunction) -> TimeResponse:
    """Return the response of a rational transform in s, or in z or q."""
    is_discrete = Y.time == "discrete"
    if Y.time is None:
        raise InputError(
            f"a response in time depends on the time domain of {Y.variable}; write s for "
            "continuous time, z or q for discrete time"
        )
    if is_discrete and not Y.is_proper:
        raise ImproperError(
            f"{Y} is improper in {Y.variable}: its response would begin before step 0; divide by "
            f"a power of {Y.variable}"
        )
    reduced = Y.reduced()
    shifted = reduced
    if is_discrete:
        one = TransferFunction(Poly(1, Y.variable, domain="QQ"), Poly(Y.variable, domain="QQ"))
        shifted = (reduced * one).reduced()
    parts = partial_fractions(shifted)
    by_factor: dict[Poly, list[Poly]] = {}
    for term in parts.terms:
        p, numerator = over_coefficient_field(term.factor, term.numerator)
        coefficients = by_factor.setdefault(term.factor, [])
        principal = _principal_part(numerator, p, term.power)
        zero = Poly(0, p.gen, domain="QQ")
        coefficients += [zero] * (term.power - len(coefficients))
        for j, c in enumerate(principal):
            coefficients[j] += c
    modes = tuple(
        Mode(canonical(p), tuple(map(canonical, coefficients)))
        for p, coefficients in by_factor.items()
    )
    used = names_in_all(Y.numerator, Y.denominator) | {Y.variable.name}
    used |= {str(x) for p in (Y.numerator, Y.denominator) for x in p.free_symbols}
    time = fresh(used, *(("k", "n") if is_discrete else ("t", "tau")))
    return TimeResponse(reduced, parts.polynomial, modes, time)


def _principal_part(numerator: Poly, p: Poly, power: int) -> list[Poly]:
    r"""Return c_1, ..., c_m of N/p^m about a root of p, as polynomials modulo p.

    With :math:`q(\varepsilon) = p(r + \varepsilon)/\varepsilon`, the coefficient of
    :math:`\varepsilon^i` in :math:`N(r + \varepsilon)/q^m` is c_{m - i}.
    """
    series, inverse = _taylor(numerator, p, power), _inverse_quotient(p, power)
    for _ in range(power):
        series = _product(series, inverse, p)
    return series[::-1]


@lru_cache(maxsize=8)  # the entries of a matrix have the same p
def _inverse_quotient(p: Poly, power: int) -> Series:
    """Return the first coefficients of 1/q in eps."""
    slope = _taylor(p.diff(), p, power)
    return _inverse([c.quo_ground(i + 1) for i, c in enumerate(slope)], p)  # p^(i+1)(r)/(i+1)!


def _taylor(poly: Poly, p: Poly, size: int) -> Series:
    """Return the first coefficients of poly(r + eps) in eps."""
    series, derivative = [], poly
    for i in range(size):
        series.append(derivative.rem(p).quo_ground(factorial(i)))
        derivative = derivative.diff()
    return series


def _product(a: Series, b: Series, p: Poly) -> Series:
    zero = Poly(0, p.gen, domain=p.domain)
    return [
        sum((product_modulo(p, a[j], b[i - j]) for j in range(i + 1)), zero) for i in range(len(a))
    ]


def _inverse(a: Series, p: Poly) -> Series:
    """Invert a power series modulo p; its first coefficient is p'(r), which is not zero."""
    head = quotient_modulo(p, Poly(1, p.gen, domain=p.domain), a[0])
    inverse = [head]
    for i in range(1, len(a)):
        zero = Poly(0, p.gen, domain=p.domain)
        rest = sum((product_modulo(p, a[j], inverse[i - j]) for j in range(1, i + 1)), zero)
        inverse.append(product_modulo(p, -rest, head))
    return inverse
