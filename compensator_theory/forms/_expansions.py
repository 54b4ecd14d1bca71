"""Expansions of exact transfer functions: Markov parameters and partial fractions."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, fraction, latex, total
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._quotients_modulo import quotient_modulo
from compensator_theory.polynomials._budget import ask, integer
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._complex_polynomials import over_gaussian_rationals
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._poly import (
    canonical,
    over_coefficient_field,
)
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._transfer_functions import (
    TransferFunction,
    require_proper,
)


@holds_where_defined
@carrying()
def markov_parameters(
    G: TransferFunctionLike, count: int, *, variable: str | Symbol | None = None
) -> tuple[Expr, ...]:
    r"""Return the first coefficients of the expansion at infinity, the impulse response in z.

    .. math:: G(s) = H_0 + \frac{H_1}{s} + \frac{H_2}{s^2} + \cdots, \qquad
              H_k = N_{n-k} - \sum_{j=1}^{k} D_{n-j} H_{k-j}

    Parameters
    ----------
    G : transfer function
        Proper, of order n; anything :func:`transfer_function` reads.
    count : int
        How many; the first is H_0 = G(oo).
    variable : str or Symbol, optional
        Default: evident.

    Raises
    ------
    ImproperError
        If G is improper.
    InputError
        If `count` is no positive integer.

    Notes
    -----
    :math:`H_k = C A^{k-1} B` for every realisation. ``rcac_numeric.targets.markov_parameters`` has
    those of several signals, each rounded once. Source: (2.51), (3.8).

    Examples
    --------
    >>> from compensator_theory import markov_parameters
    >>> markov_parameters("(s + 5)/(s**2 + 3*s + 2)", 5)
    (0, 1, 2, -8, 20)
    """
    integer(count, "count", at_least=1)
    ask("degree", count - 1, "the expansion")
    G = transfer_function(G, variable)
    require_proper(G, "transfer function")
    n, domain = G.order, G.numerator.unify(G.denominator)[0].domain.get_field()
    top, bottom = (side.set_domain(domain) for side in (G.numerator, G.denominator))
    above, below = ([domain.zero] * (n + 1 - len(c)) + c for c in (
        top.rep.to_list(), bottom.rep.to_list()))  # fmt: skip
    parameters: list[object] = []
    for k in range(count):
        value = above[k] if k <= n else domain.zero
        for j in range(1, min(k, n) + 1):
            value -= below[j] * parameters[k - j]
        parameters.append(value)
    return tuple(map(domain.to_sympy, parameters))


@dataclass(frozen=True)
class PartialFraction(ExactValue):
    """One term numerator/factor**power, the degree of the numerator below that of the factor.

    Examples
    --------
    >>> from compensator_theory import partial_fractions
    >>> print(partial_fractions("1/(s**2*(s + 1))").terms[0])
    (-1)/(s)
    """

    numerator: Poly
    factor: Poly
    power: int

    def __str__(self) -> str:
        top, bottom = (f"({format_polynomial(part)})" for part in (self.numerator, self.factor))
        if self.numerator.degree() < 1 and top.startswith("(("):  # a sum is in brackets already
            top = top[1:-1]
        return f"{top}/{bottom}" + (f"**{self.power}" if self.power > 1 else "")

    def _repr_latex_(self) -> str:
        bottom = self.factor.as_expr() ** self.power
        return displayed(fraction(self.numerator, bottom))


@dataclass(frozen=True)
class PartialFractions(ExactValue):
    """A polynomial and partial fractions, with the check that they sum up to the source.

    Attributes
    ----------
    polynomial : Poly
        0 for a strictly proper transfer function.
    terms : tuple of PartialFraction
        By factor, each in ascending powers; factors are monic and irreducible over the field of the
        coefficients.
    certificate : Certificate
        The sum over one denominator, less the source.

    Examples
    --------
    >>> from compensator_theory import partial_fractions
    >>> expansion = partial_fractions("(s + 5)/(s**2 + 3*s + 2)")
    >>> print(expansion, expansion.certificate.holds)
    (4)/(s + 1) + (-3)/(s + 2) True
    """

    polynomial: Poly
    terms: tuple[PartialFraction, ...]
    certificate: Certificate

    def __str__(self) -> str:
        whole = [] if self.polynomial.is_zero else [format_polynomial(self.polynomial)]
        return " + ".join(whole + [str(term) for term in self.terms]) or "0"

    def _repr_latex_(self) -> str:
        terms = [] if self.polynomial.is_zero else [latex(self.polynomial)]
        return displayed(total([*terms, *map(latex, self.terms)]) or "0")


@holds_where_defined
@carrying()
def partial_fractions(
    G: TransferFunctionLike, variable: str | Symbol | None = None
) -> PartialFractions:
    r"""Expand a transfer function in partial fractions over the field of its coefficients.

    .. math:: \frac ND = P + \sum_i \sum_{k=1}^{m_i} \frac{N_{ik}}{p_i^k}, \qquad
              \deg N_{ik} < \deg p_i

    Parameters
    ----------
    G : transfer function
        Anything :func:`transfer_function` reads. Factors that numerator and denominator share are
        cancelled first: they have no term. A text or an expression may have complex coefficients
        with rational parts.
    variable : str or Symbol, optional
        Default: evident.

    Returns
    -------
    PartialFractions
        Irreducible factors p_i, linear ones where the poles are rational; nothing is rounded.

    Examples
    --------
    >>> from compensator_theory import partial_fractions
    >>> print(partial_fractions("s**3/((s - 1)*(s**2 + 1))"))
    1 + (1/2)/(s - 1) + (s/2 - 1/2)/(s**2 + 1)
    >>> print(partial_fractions("1/((s + 1 - 2*I)*(s + 3))"))
    (1/4 - I/4)/(s + (1 - 2*I)) + (-1/4 + I/4)/(s + 3)
    """
    if (sides := over_gaussian_rationals(G, variable)) is not None:
        return _complex_fractions(*sides)
    G = transfer_function(G, variable)
    reduced = G.reduced()
    top, bottom = over_coefficient_field(reduced.numerator, reduced.denominator)
    whole, digits = _expanded(top, bottom)
    terms = [PartialFraction(canonical(N), canonical(p), power) for N, p, power in digits]
    return PartialFractions(
        canonical(whole), tuple(terms), _certificate(G, canonical(whole), terms)
    )


def _expanded(top: Poly, bottom: Poly) -> tuple[Poly, list[tuple[Poly, Poly, int]]]:
    """Return the polynomial and the fractions N/p**power of a reduced quotient over a field."""
    whole, rest = top.div(bottom)
    terms = []
    factors = sorted(bottom.factor_list()[1], key=lambda item: _by_degree(item[0]))
    for factor, multiplicity in factors:
        p = factor.monic()
        local = p**multiplicity
        # The part over p**m is N (D/p**m)**-1 modulo p**m; its digits in base p are the numerators.
        value = quotient_modulo(local, rest, bottom.quo(local))
        digits = []
        for _ in range(multiplicity):
            value, digit = value.div(p)
            digits.append(digit)
        terms += [
            (digit, p, multiplicity - j)
            for j, digit in reversed(list(enumerate(digits)))
            if not digit.is_zero
        ]
    return whole, terms


def _complex_fractions(top: Poly, bottom: Poly) -> PartialFractions:
    """Expand a quotient with complex coefficients over the field of their rational parts."""
    common = top.gcd(bottom)
    N, D = top.exquo(common), bottom.exquo(common)
    whole, digits = _expanded(N, D)
    back = whole * D
    for numerator, factor, power in digits:
        back += numerator * D.exquo(factor**power)
    left = [sympy.expand(c) for c in (back - N).all_coeffs()]
    certificate = certificate_of("the sum over one denominator = N/D", [left], "expansion")
    return PartialFractions(whole, tuple(PartialFraction(*digit) for digit in digits), certificate)


def _certificate(G: TransferFunction, whole: Poly, terms: list[PartialFraction]) -> Certificate:
    total = TransferFunction(whole, Poly(1, G.variable, domain="QQ"))
    for term in terms:
        total += TransferFunction(term.numerator, term.factor**term.power)
    difference = total.numerator * G.denominator - G.numerator * total.denominator
    identity = "the sum of the terms = N/D"
    return Certificate(identity, ImmutableMatrix([[canonical(difference).as_expr()]]))


def _by_degree(factor: Poly) -> tuple[int, str]:
    return int(factor.degree()), str(factor.as_expr())
