"""The poles of a regulator as its input weight goes from 0 to infinity."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import QQ, Expr, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import CompensatorError, ImproperError, InputError
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._reading import PolynomialLike, in_one_variable
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time, time_of
from compensator_theory.roots._counts import require_rational
from compensator_theory.roots._enclosures import text_of
from compensator_theory.roots._reflections import spectrum_of
from compensator_theory.roots._spectral_factors import SpectralFactor, spectral_factor

R_2 = Symbol("R_2")


@dataclass(frozen=True)
class RegulatorLocus(ExactValue):
    r"""The closed-loop poles of an LQ regulator with the cost :math:`z^2 + R_2u^2`.

    .. math:: p(\lambda; R_2) = N N^* + R_2\, D D^*

    with :math:`N^*(s) = N(-s)` in continuous and :math:`z^nN(1/z)` in discrete time.

    Attributes
    ----------
    numerator, denominator : sympy.Poly
        N and D of the transfer function from u to z, :math:`\deg N \le \deg D = n`.

    Examples
    --------
    >>> from compensator_theory import regulator_locus
    >>> locus = regulator_locus("s - 1", "(s + 1)*(s + 2)")
    >>> print(locus)
    R_2*s**4 + (-5*R_2 - 1)*s**2 + (4*R_2 + 1)
    R_2 -> 0: s + 1, and 1 pole(s) to infinity at the distance 1/sqrt(R_2)
    R_2 -> oo: s**2 + 3*s + 2
    """

    numerator: Poly
    denominator: Poly

    @property
    def time(self) -> Time:
        """The time domain that the variable s, z or q stands for."""
        return time_of(self.denominator.gen, "the locus")

    @property
    def spectrum(self) -> Poly:
        """P as a polynomial whose coefficients are linear in R_2."""
        N, D = self.numerator, self.denominator
        n = int(D.degree())
        parts = spectrum_of(N, n, self.time), spectrum_of(D, n, self.time)
        first, second = (part.set_domain(QQ[R_2]) for part in parts)
        return canonical(first + second * Poly(R_2, D.gen, domain=QQ[R_2]))

    def at(self, weight: object, *, digits: int = 30) -> SpectralFactor:
        """Return the closed-loop polynomial for one value of R_2, rational and at least 0.

        For 0 this is :attr:`cheap`.

        Raises
        ------
        UnitCircleError, NoSolutionError
            If a pole is on the boundary of stability.
        InputError
            If the weight is negative or no rational number.
        """
        N, D = self.numerator, self.denominator
        return spectral_factor(N, D, weight, time=self.time, digits=digits)

    @property
    def cheap(self) -> SpectralFactor:
        r"""Limits of the finite poles as :math:`R_2 \to 0`: the zeros, unstable ones reflected.

        In discrete time all n poles stay finite, :math:`n - m` of them at 0.

        Raises
        ------
        UnitCircleError, NoSolutionError
            If a zero is on the boundary of stability, so that the limit is no stable polynomial.
        """
        return self.at(0)

    @property
    def expensive(self) -> SpectralFactor:
        r"""Limits as :math:`R_2 \to \infty`: the open-loop poles, unstable ones reflected.

        Raises
        ------
        UnitCircleError, NoSolutionError
            If a pole is on the boundary of stability, an integrator for instance, so that the limit
            is no stable polynomial.
        """
        return spectral_factor(self.denominator, time=self.time)

    @property
    def number_to_infinity(self) -> int:
        r"""Number of poles that go to infinity as :math:`R_2 \to 0`; 0 in discrete time."""
        if self.time == "discrete":
            return 0
        return int(self.denominator.degree() - self.numerator.degree())

    @property
    def distance(self) -> Expr:
        r"""Distance of these poles from 0, to first order: a Butterworth pattern.

        .. math:: |\lambda| \to \left(b^2/(a^2R_2)\right)^{1/(2k)}, \qquad k = n - m
        """
        k = self.number_to_infinity
        if k == 0:
            return sympy.S.Zero
        ratio = sympy.Abs(self.numerator.LC() / self.denominator.LC())
        return ratio ** sympy.Rational(1, k) * R_2 ** sympy.Rational(-1, 2 * k)

    @property
    def closed_form(self) -> tuple[Expr, ...] | None:
        r"""Coefficients of the closed-loop polynomial as functions of R_2, for low orders.

        .. math:: c s^4 - bs^2 + d = c\,\chi(s)\chi(-s), \qquad
                  \chi = s^2 + \sqrt{b/c + 2\sqrt{d/c}}\; s + \sqrt{d/c}

        and in discrete time by :math:`\chi(1)` and :math:`\chi(-1)`, whose squares are known up to
        c. Descending and monic; None above n = 2, where the coefficients are no square roots.
        """
        n = int(self.denominator.degree())
        if n > 2:
            return None
        if self.time == "discrete":
            return self._discrete_form(n)
        c, *middle, d = self.spectrum.all_coeffs()[::2]
        if n == 1:
            return sympy.S.One, sympy.sqrt(sympy.cancel(-d / c))
        last = sympy.sqrt(sympy.cancel(d / c))
        return sympy.S.One, sympy.sqrt(sympy.cancel(-middle[0] / c) + 2 * last), last

    def _discrete_form(self, n: int) -> tuple[Expr, ...]:
        """With c chi(1)^2 = P, c chi(-1)^2 = M (chi(-1) < 0 for n = 1) and c chi(0) known."""
        p = self.spectrum
        P, M = sympy.expand(p.eval(1)), sympy.expand((-1) ** n * p.eval(-1))
        plus, less = sympy.sqrt(P), sympy.sqrt(M)
        if n == 1:
            return sympy.S.One, (plus - less) / (plus + less)
        end = p.coeff_monomial(p.gen ** (2 * n))
        root = (plus + less + sympy.sqrt((plus + less) ** 2 - 16 * end)) / 4  # of c: |chi(0)| < 1
        return sympy.S.One, (plus - less) / (2 * root), end / root**2

    def __str__(self) -> str:
        ends = []
        for end, poly in (("cheap", self.numerator), ("expensive", self.denominator)):
            try:
                limit = getattr(self, end)
                ends.append(text_of(limit.polynomial, limit.enclosure))
            except CompensatorError:  # the limit itself is not stable
                ends.append(
                    f"the roots of {format_polynomial(poly)}, some of them on the boundary of "
                    "stability, unstable ones reflected"
                )
        k = self.number_to_infinity
        away = f", and {k} pole(s) to infinity at the distance {text(self.distance)}" if k else ""
        return (
            f"{format_polynomial(self.spectrum)}\nR_2 -> 0: {ends[0]}{away}\nR_2 -> oo: {ends[1]}"
        )

    def _repr_latex_(self) -> str:
        return displayed(latex(self.spectrum))


@refusing
def regulator_locus(
    N: PolynomialLike, D: PolynomialLike, *, variable: str | Symbol | None = None
) -> RegulatorLocus:
    r"""Follow the poles of LQG as :math:`R_2` goes from 0 to infinity, with the exact limits.

    .. math:: c\,\chi\chi^* = N N^* + R_2\, D D^*

    Parameters
    ----------
    N, D : polynomial
        Of the transfer function from u to z (of w to y for the estimator, with :math:`V_2`),
        rational, in s, z or q.
    variable : str or Symbol, optional
        Default: evident from N or D.

    Returns
    -------
    RegulatorLocus

    Raises
    ------
    ImproperError
        If deg N > deg D.
    InputError
        If N or D is zero, symbolic, or written in another variable.

    Notes
    -----
    High authority is the end :math:`R_2 \to 0`. In discrete time it is reached by a finite gain,
    :func:`lqg_controller`; in continuous time the gain grows without a bound, and only the
    poles that go to zeros have limits.

    Examples
    --------
    >>> from compensator_theory import regulator_locus
    >>> locus = regulator_locus("z - 2", "(z - 1/2)*(z - 1/3)")
    >>> locus.cheap.polynomial.as_expr()
    z**2 - z/2
    >>> regulator_locus("1", "s**2").closed_form
    (1, sqrt(2)*(1/R_2)**(1/4), sqrt(1/R_2))
    """
    numerator, denominator = map(require_rational, in_one_variable(N, D, variable=variable))
    if numerator.degree() > denominator.degree():
        raise ImproperError(
            f"deg N = {numerator.degree()} exceeds deg D = {denominator.degree()}; no regulator "
            "has such a transfer function from u to z"
        )
    time_of(denominator.gen, "the locus")
    if denominator.degree() == 0:
        raise InputError("the plant has no pole that could move; give D of degree 1 or more")
    return RegulatorLocus(numerator, denominator)
