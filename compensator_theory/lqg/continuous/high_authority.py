"""High-authority LQG in continuous time: which poles have limits, and how the others leave."""

from dataclasses import dataclass

import flint
import sympy
from sympy import QQ, Expr, Matrix, Poly, Rational, Symbol

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.latex import displayed, latex, lines
from compensator_theory.lqg.continuous.butterworth_patterns import (
    ButterworthPattern,
    butterworth_patterns,
)
from compensator_theory.lqg.locus import R_2
from compensator_theory.lqg.poles import require_stable_hidden_modes
from compensator_theory.lqg.regulator_spectra import continuous_regulator_spectrum, interpolated
from compensator_theory.matrices.flint_matrices import rational
from compensator_theory.matrices.linear_algebra import rank
from compensator_theory.polynomials.budget import shown
from compensator_theory.polynomials.poly import canonical
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import is_discrete
from compensator_theory.roots.counts import count_half_plane_roots
from compensator_theory.roots.enclosures import latex_of
from compensator_theory.roots.half_plane_factors import HalfPlaneFactor, factor_even
from compensator_theory.systems.standard_problems import StandardProblem


@dataclass(frozen=True)
class HighAuthorityLimit(ExactValue):
    r"""The poles of a regulator, or of an estimator, as its weight :math:`\rho R_2` goes to 0.

    .. math:: p(s; \rho) = \det\!\left(G^T(-s)\,G(s) + \rho R_2\right) D(s)\,D(-s)

    Attributes
    ----------
    spectrum : sympy.Poly
        p, in s, with coefficients in R_2, which stands for :math:`\rho`.
    finite : HalfPlaneFactor
        The limits of the poles that have one: for as many inputs as outputs the zeros of G, those
        of the right half plane reflected. A simple one is reached with an error of order rho.
    patterns : tuple of ButterworthPattern
        The others, by ascending order.
    """

    spectrum: Poly
    finite: HalfPlaneFactor
    patterns: tuple[ButterworthPattern, ...]

    @property
    def number_to_infinity(self) -> int:
        """How many poles leave every bounded set."""
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
class ContinuousHighAuthority(ExactValue):
    """Where LQG in continuous time puts the poles as its weights go to nothing.

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


def continuous_high_authority(
    plant: StandardProblem, *, digits: int = 30
) -> ContinuousHighAuthority:
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
    ContinuousHighAuthority

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
    The counterpart of :func:`high_authority_lqg`, whose n poles are all finite. Here the gains grow
    without a bound, and :math:`n - m` poles leave: for scalar z and u one pattern of order
    :math:`k = n - m`, the relative degree, with :math:`c = H^2`, H the leading coefficient of
    :math:`N_{zu}`; for several signals one for each zero at infinity of G, of its order, from the
    Newton polygon of p in R_2. So (4.24) has no counterpart as a limit of loops: only after
    division by `growth` does the closed-loop polynomial converge, and its target model times
    `growth` is improper in general. Source: H. Kwakernaak and R. Sivan, Linear Optimal Control
    Systems (1972), Section 3.8; H. Kwakernaak, IEEE Trans. Automatic Control 21 (1976) 378-384.

    Examples
    --------
    >>> from compensator_theory import StandardProblem, continuous_high_authority
    >>> plant = StandardProblem(A=[[0, 1, 0], [0, 0, 1], [0, 0, 0]], B=[[0], [0], [1]],
    ...     C=[[1, 0, 0]], D_1=[[0], [0], [3]], D_0=None, D_2=[[0]], E_1=[[-2, 2, 0]], E_2=[[0]],
    ...     E_0=None, variable="s")
    >>> limits = continuous_high_authority(plant)
    >>> print(limits)  # G_zu = 2 (s - 1)/s**3, G_yw = 3/s**3
    regulator: s + 1; 2 pole(s) to infinity at the distance sqrt(2)/R_2**(1/4)
    estimator: 1; 3 pole(s) to infinity at the distance 3**(1/3)/R_2**(1/6)
    >>> limits.regulator.patterns[0].angles
    (3*pi/4, 5*pi/4)
    """
    if not isinstance(plant, StandardProblem):
        raise InputError(f"{shown(plant)} is not a StandardProblem; see standard_problem()")
    s = plant.variable
    if is_discrete(s, "high-authority LQG"):
        raise InputError(f"{s} means discrete time; use high_authority_lqg or lqg_poles")
    require_stable_hidden_modes(plant, count_half_plane_roots, "left of the imaginary axis")
    return ContinuousHighAuthority(
        _limit((plant.A, plant.B, plant.E_1, plant.E_2), ("E_1'E_2", "E_2"), s, digits),
        _limit(
            (plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T), ("D_1 D_2'", "D_2"), s, digits
        ),
    )  # fmt: skip


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
        finite = factor_even(canonical(Poly(even, s)), digits)
    except NoSolutionError as error:
        raise NoSolutionError(
            f"a zero on the imaginary axis is the limit of poles, so that the limit is no stable "
            f"loop: {error}"
        ) from error
    descending: list[Expr] = []
    for c in reversed(coefficients):
        descending += [sum(v * R_2**i for i, v in enumerate(c)), sympy.S.Zero]
    spectrum = canonical(Poly(descending[:-1], s, domain=QQ[R_2]))
    return HighAuthorityLimit(spectrum, finite, butterworth_patterns(known, last))


def _coefficients(
    matrices: tuple[Matrix, ...], names: tuple[str, str], s: Symbol
) -> list[list[Rational]]:
    """Return the coefficients of s**0, s**2, ..., each ascending in the weight."""
    A, B, E_1, E_2 = matrices
    width = int(B.cols)
    if not (E_1.T * E_2).is_zero_matrix:
        raise InputError(f"{names[0]} is not zero; the limits are for costs without cross terms")
    unit = sympy.eye(width) if E_2.is_zero_matrix else E_2
    if rank(unit.T * unit) < width:
        raise InputError(f"{names[1]} weighs some signals only; let it be zero or weigh all")
    outputs = Matrix.vstack(E_1, sympy.zeros(unit.rows, A.rows))
    spectra = []
    for k in range(width + 1):
        inputs = Matrix.vstack(sympy.zeros(E_1.rows, width), k * unit)
        spectra.append(continuous_regulator_spectrum(A, B, outputs, inputs, s))
    points = [flint.fmpq(k * k) for k in range(width + 1)]
    found = []
    for j in range(A.rows + 1):
        column = [p.coeff_monomial(s ** (2 * j)) for p in spectra]
        values = [flint.fmpq(int(c.p), int(c.q)) for c in column]
        found.append([rational(c) for c in interpolated(points, values)])
    return found


def _order(ascending: list[Rational]) -> tuple[int, Rational]:
    """Return the lowest power and its coefficient."""
    return next((i, value) for i, value in enumerate(ascending) if value != 0)
