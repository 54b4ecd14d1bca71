"""High-authority LQG in continuous time: limits of the poles, and the poles that go to infinity."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import flint
import sympy
from sympy import QQ, Expr, Matrix, Poly, Rational, Symbol

from compensator_theory._latex import displayed, fraction, latex, lines
from compensator_theory._printing import text
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.lqg._locus import R_2
from compensator_theory.lqg._poles import require_stable_hidden_modes
from compensator_theory.lqg._regulator_data import regulator_and_estimator
from compensator_theory.lqg._regulator_spectra import regulator_spectrum
from compensator_theory.matrices._flint_matrices import identity_matrix, rational
from compensator_theory.matrices._flint_polynomials import interpolated
from compensator_theory.matrices._linear_algebra import rank
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import time_of
from compensator_theory.roots._enclosures import latex_of
from compensator_theory.roots._spectral_factors import SpectralFactor, factor_spectrum
from compensator_theory.systems._standard_problems import StandardProblem


@dataclass(frozen=True)
class ButterworthPattern(ExactValue):
    r"""Poles that go to infinity together, evenly spread over a half circle.

    .. math:: \lambda_i = \left(\frac{c}{\rho}\right)^{1/(2k)} e^{\mathrm{j}\theta_i}
              + O(\rho^{1/(2k)}), \qquad
              \theta_i = \frac{\pi}{2} + \frac{(2i + 1)\pi}{2k}, \quad i = 0, \ldots, k - 1

    The bound of the error is for a gain c that no other pattern of the same order has.

    Attributes
    ----------
    order : int
        k, the number of the poles.
    gain : sympy.Expr
        c > 0, exact: rational, with a square root, or a CRootOf.
    """

    order: int
    gain: Expr

    @property
    def angles(self) -> tuple[Expr, ...]:
        """The k angles in rad, between pi/2 and 3 pi/2."""
        k = self.order
        return tuple(sympy.pi * (Rational(1, 2) + Rational(2 * i + 1, 2 * k)) for i in range(k))

    @property
    def distance(self) -> Expr:
        """The distance from 0 as a function of the weight R_2."""
        root = Rational(1, 2 * self.order)
        return self.gain**root * R_2**-root

    def poles(self, weight: NumberLike) -> tuple[Expr, ...]:
        """Return the k poles, to first order, for a weight.

        Raises
        ------
        InputError
            If the weight is not a positive rational number.
        """
        value = exact_number(weight)
        if not (value.is_Rational and value > 0):
            raise InputError(f"the weight {value} must be a positive rational number")
        distance = self.distance.subs(R_2, value)
        return tuple(distance * sympy.exp(sympy.I * angle) for angle in self.angles)

    def __str__(self) -> str:
        return f"{self.order} pole(s) to infinity at the distance {text(self.distance)}"

    def _repr_latex_(self) -> str:
        k = self.order
        angle = rf"\theta_i = \frac{{\pi}}{{2}} + \frac{{(2i + 1)\pi}}{{{2 * k}}}"
        distance = rf"\left({fraction(self.gain, R_2)}\right)^{{1/{2 * k}}}"
        return displayed(
            rf"\lambda_i \approx {distance} e^{{\mathrm{{j}}\theta_i}}", angle, f"i < {k}"
        )


@dataclass(frozen=True)
class HighAuthorityLimit(ExactValue):
    r"""The poles of a regulator, or of an estimator, as its weight :math:`\rho R_2` goes to 0.

    .. math:: p(s; \rho) = \det\!\left(G^T(-s)\,G(s) + \rho R_2\right) D(s)\,D(-s)

    Attributes
    ----------
    spectrum : sympy.Poly
        p, in s, with coefficients in R_2, which stands for :math:`\rho`.
    finite : SpectralFactor
        The limits of the poles that have one: for as many inputs as outputs the zeros of G, those
        of the right half plane reflected. A simple one is reached with an error of order rho.
    patterns : tuple of ButterworthPattern
        The others, by ascending order.
    """

    spectrum: Poly
    finite: SpectralFactor
    patterns: tuple[ButterworthPattern, ...]

    @property
    def number_to_infinity(self) -> int:
        """Number of poles that go to infinity."""
        return sum(pattern.order for pattern in self.patterns)

    @property
    def growth(self) -> Expr:
        r"""The factor g of the limit of the whole polynomial, as a function of R_2.

        .. math:: \chi(s; \rho)/g(\rho) \to \chi_f(s) \text{ for every } s, \qquad
                  g = \textstyle\prod_i \sqrt{c_i/\rho}
        """
        gains = sympy.Mul(*(pattern.gain for pattern in self.patterns))
        return sympy.sqrt(gains) * R_2 ** -Rational(len(self.patterns), 2)

    def __str__(self) -> str:
        finite = str(self.finite).split("\n", maxsplit=1)[0].removeprefix("χ = ")
        return "; ".join([finite, *map(str, self.patterns)])

    def _repr_latex_(self) -> str:
        return displayed(self._finite(), *(_distance(p, "R_2") for p in self.patterns))

    def _finite(self) -> str:
        return latex_of(self.finite.polynomial, self.finite.enclosure)


@dataclass(frozen=True)
class HighAuthorityLimits(ExactValue):
    """The limits of the continuous-time LQG poles as the weights go to 0.

    Attributes
    ----------
    regulator, estimator : HighAuthorityLimit
        As the weight of u, and as the intensity of the sensor noise, goes to 0.
    """

    regulator: HighAuthorityLimit
    estimator: HighAuthorityLimit

    def __str__(self) -> str:
        return f"regulator: {self.regulator}\nestimator: {self.estimator}"

    def _repr_latex_(self) -> str:
        rows = []
        for name, part in (("R_2", self.regulator), ("V_2", self.estimator)):
            limits = ", ".join([part._finite(), *(_distance(p, name) for p in part.patterns)])
            rows.append(rf"{name} \to 0: \; {limits}")
        return displayed(lines(rows))


def _distance(pattern: ButterworthPattern, weight: str) -> str:
    gain = latex(pattern.gain)
    return rf"|\lambda| \approx \left({gain}/{weight}\right)^{{1/{2 * pattern.order}}}"


@refusing
def high_authority_limits(plant: StandardProblem, *, digits: int = 30) -> HighAuthorityLimits:
    r"""Find the exact limits of the LQG poles in continuous time as the weights go to 0.

    .. math:: \chi(s; \rho) \to g(\rho)\,\chi_f(s), \qquad
              \lambda^{2k} \approx (-1)^{k+1}\,c/\rho \text{ for all others}

    Parameters
    ----------
    plant : StandardProblem
        Rational, written in s, any number of signals. Where :math:`E_2 = 0`, the weight of u is
        :math:`\rho I`, else :math:`\rho E_2^TE_2`, which is nonsingular, with :math:`E_1^TE_2 =
        0`. Likewise D_2 for the sensor noise.
    digits : int
        Where a finite part is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.

    Returns
    -------
    HighAuthorityLimits

    Raises
    ------
    NotControllableError, NotObservableError
        If a hidden mode is not left of the imaginary axis.
    NoSolutionError
        If a limit is on the imaginary axis.
    InputError
        If there is a cross term, a weight is singular but not zero, an entry is symbolic, or the
        plant is not written in s.

    Notes
    -----
    The counterpart of :func:`lqg_controller` with :math:`R_2 = 0` in discrete time, whose n poles
    are all finite. Here the gains grow
    without a bound, and :math:`n - m` poles leave: for scalar z and u one pattern of order
    :math:`k = n - m`, the relative degree, with :math:`c = H^2`, H the leading coefficient of
    :math:`N_{zu}`; for several signals one for each zero at infinity of G, of its order, from the
    Newton polygon of p in R_2. So (4.24) has no counterpart as a limit of loops: only after
    division by `growth` does the closed-loop polynomial converge, and its target model times
    `growth` is improper in general. Source: H. Kwakernaak and R. Sivan, Linear Optimal Control
    Systems (1972), Section 3.8; H. Kwakernaak, IEEE Trans. Automatic Control 21 (1976) 378-384.

    Examples
    --------
    >>> from compensator_theory import StandardProblem, high_authority_limits
    >>> plant = StandardProblem(A=[[0, 1, 0], [0, 0, 1], [0, 0, 0]], B=[[0], [0], [1]],
    ...     C=[[1, 0, 0]], D_1=[[0], [0], [3]], D_0=None, D_2=[[0]], E_1=[[-2, 2, 0]], E_2=[[0]],
    ...     E_0=None, variable="s")
    >>> limits = high_authority_limits(plant)
    >>> print(limits)  # G_zu = 2 (s - 1)/s**3, G_yw = 3/s**3
    regulator: s + 1; 2 pole(s) to infinity at the distance sqrt(2)/R_2**(1/4)
    estimator: 1; 3 pole(s) to infinity at the distance 3**(1/3)/R_2**(1/6)
    >>> limits.regulator.patterns[0].angles
    (3*pi/4, 5*pi/4)
    """
    regulator, estimator = regulator_and_estimator(plant)
    s = plant.variable
    if time_of(s, "high-authority LQG") == "discrete":
        raise InputError(
            f"{s} means discrete time, in which all poles have limits: those of lqg_poles, or "
            "lqg_controller, for E_2 = 0 and D_2 = 0"
        )
    require_stable_hidden_modes(plant, "continuous")
    return HighAuthorityLimits(
        _limit(regulator, ("E_1'E_2", "E_2"), s, digits),
        _limit(estimator, ("D_1 D_2'", "D_2"), s, digits),
    )


def _limit(
    matrices: tuple[Matrix, ...], names: tuple[str, str], s: Symbol, digits: int
) -> HighAuthorityLimit:
    coefficients = _coefficients(matrices, names, s)
    known = {j: _order(c) for j, c in enumerate(coefficients) if any(c)}
    least = min(order for order, _ in known.values())
    last = max(j for j, (order, _) in known.items() if order == least)
    even: list[Expr] = [sympy.S.Zero] * (2 * last + 1)
    for j, (order, value) in known.items():
        if order == least:
            even[2 * (last - j)] = value
    try:
        finite = factor_spectrum(canonical(Poly(even, s)), last, "continuous", digits)
    except NoSolutionError as error:
        raise NoSolutionError(
            f"a zero on the imaginary axis is the limit of poles, so that the limit is no stable "
            f"loop: {error}"
        ) from error
    descending: list[Expr] = []
    for c in reversed(coefficients):
        descending += [sum(v * R_2**i for i, v in enumerate(c)), sympy.S.Zero]
    spectrum = canonical(Poly(descending[:-1], s, domain=QQ[R_2]))
    return HighAuthorityLimit(spectrum, finite, _butterworth_patterns(known, last))


def _coefficients(
    matrices: tuple[Matrix, ...], names: tuple[str, str], s: Symbol
) -> list[list[Rational]]:
    """Return the coefficients of s**0, s**2, ..., each ascending in the weight."""
    A, B, E_1, E_2 = matrices
    width = int(B.cols)
    if not (E_1.T * E_2).is_zero_matrix:
        raise InputError(f"{names[0]} is not zero; the limits are for costs without cross terms")
    unit = identity_matrix(width) if E_2.is_zero_matrix else E_2
    if rank(unit.T * unit) < width:
        raise InputError(f"{names[1]} weighs some signals only; let it be zero or weigh all")
    outputs = Matrix.vstack(E_1, sympy.zeros(unit.rows, A.rows))
    spectra = []
    for k in range(width + 1):
        inputs = Matrix.vstack(sympy.zeros(E_1.rows, width), k * unit)
        spectra.append(
            regulator_spectrum(A, B, E_1=outputs, E_2=inputs, time="continuous", variable=s)
        )
    points = [flint.fmpq(k * k) for k in range(width + 1)]
    coefficients = []
    for j in range(A.rows + 1):
        column = [p.coeff_monomial(s ** (2 * j)) for p in spectra]
        values = [flint.fmpq(int(c.p), int(c.q)) for c in column]
        coefficients.append([rational(c) for c in interpolated(points, values)])
    return coefficients


def _order(ascending: list[Rational]) -> tuple[int, Rational]:
    """Return the lowest power and its coefficient."""
    return next((i, value) for i, value in enumerate(ascending) if value != 0)


def _butterworth_patterns(
    known: dict[int, tuple[int, Rational]], start: int
) -> tuple[ButterworthPattern, ...]:
    """Read the edges of positive slope of a Newton polygon; each has slope 1/k, k natural.

    `known` has for every j the lowest power of the weight in the coefficient of s**(2 j), and its
    factor; `start` is the largest j with the lowest power of all.
    """
    corners = [start]
    while corners[-1] < max(known):
        j, v = corners[-1], known[corners[-1]][0]
        slopes = {i: Rational(known[i][0] - v, i - j) for i in known if i > j}
        steepest = min(slopes.values())
        corners.append(max(i for i, slope in slopes.items() if slope == steepest))
    patterns = []
    for first, last in pairwise(corners):
        rise = known[last][0] - known[first][0]
        k = (last - first) // rise
        ask("field_degree", rise, "the gains of the poles that go to infinity")
        x = Symbol("x")
        edge = Poly(0, x, domain=QQ)
        for t in range(rise + 1):
            j = first + k * t
            order, value = known.get(j, (-1, sympy.S.Zero))
            if order == known[first][0] + t:
                edge += Poly(value * (-1) ** (j + t), x, domain=QQ) * Poly(x**t, x, domain=QQ)
        gains = [gain for gain in edge.real_roots() if gain > 0]
        if rise * k != last - first or len(gains) != rise:
            raise NoSolutionError(f"the edge {edge} is no Butterworth pattern; please report it")
        patterns += [ButterworthPattern(k, gain) for gain in gains]
    return tuple(sorted(patterns, key=lambda pattern: pattern.order))
