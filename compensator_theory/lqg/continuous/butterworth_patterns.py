"""Poles that go to infinity evenly spread over a half circle, as an input costs less and less."""

from dataclasses import dataclass
from itertools import pairwise

import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.latex import displayed, fraction
from compensator_theory.lqg.locus import R_2
from compensator_theory.polynomials.budget import ask
from compensator_theory.polynomials.numbers import NumberLike, exact_number
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.printing import text


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
        distance = self.distance.subs(R_2, positive_weight(weight))
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


def butterworth_patterns(
    known: dict[int, tuple[int, Rational]], start: int
) -> tuple[ButterworthPattern, ...]:
    """Read the edges of positive slope of a Newton polygon; each has slope 1/k, k natural.

    Parameters
    ----------
    known : dict
        For every j the lowest power of the weight in the coefficient of s**(2 j), and its factor.
    start : int
        The largest j with the lowest power of all.

    Raises
    ------
    NoSolutionError
        If the edges are no Butterworth patterns: then the polynomial was wrong.

    Examples
    --------
    >>> from sympy import Integer
    >>> from compensator_theory.lqg.continuous.butterworth_patterns import butterworth_patterns
    >>> print(butterworth_patterns({0: (0, Integer(4)), 2: (1, Integer(1))}, 0)[0])
    2 pole(s) to infinity at the distance sqrt(2)/R_2**(1/4)
    """
    corners = [start]
    while corners[-1] < max(known):
        j, v = corners[-1], known[corners[-1]][0]
        slopes = {i: Rational(known[i][0] - v, i - j) for i in known if i > j}
        steepest = min(slopes.values())
        corners.append(max(i for i, slope in slopes.items() if slope == steepest))
    found = []
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
        found += [ButterworthPattern(k, gain) for gain in gains]
    return tuple(sorted(found, key=lambda pattern: pattern.order))


def positive_weight(weight: NumberLike) -> Rational:
    """Read a weight that goes to 0.

    Raises
    ------
    InputError
        If it is not a positive rational number.

    Examples
    --------
    >>> from compensator_theory.lqg.continuous.butterworth_patterns import positive_weight
    >>> positive_weight("1e-3")
    1/1000
    """
    found = exact_number(weight)
    if not (found.is_Rational and found > 0):
        raise InputError(f"the weight {found} must be a positive rational number")
    return found
