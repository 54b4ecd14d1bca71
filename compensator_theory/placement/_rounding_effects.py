"""Effect of rounding a compensator to float64 on the closed-loop poles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import comb

import flint
from sympy import Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.loops._siso import closed_loop_of_pair
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.polynomials._budget import quoted
from compensator_theory.polynomials._numbers import exact_number
from compensator_theory.polynomials._poly import canonical, is_rational, monic, way_to_rational
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import is_discrete, time_of
from compensator_theory.roots._certified import Root, certified_roots, root_balls
from compensator_theory.roots._counts import count_roots
from compensator_theory.systems._transfer_functions import TransferFunction

DANGEROUS_SHARE = 0.1


@dataclass(frozen=True)
class RoundingEffect(ExactValue):
    """Closed-loop poles before and after the coefficients were rounded once.

    Attributes
    ----------
    target, rounded : sympy.Poly
        Closed-loop polynomial of the exact and of the rounded compensator, both exact.
    was_stable, is_stable : bool
        Before and after: every pole in the open left half plane (s) or unit disk (z, q).
    """

    target: Poly
    rounded: Poly
    was_stable: bool
    is_stable: bool

    @property
    def displacement(self) -> float:
        """Largest distance from a rounded pole to the nearest exact one."""
        return self._largest_move[0]

    @property
    def share(self) -> float:
        """The displacement over the distance of that exact pole from the stability boundary."""
        return self._largest_move[1]

    @cached_property
    def is_dangerous(self) -> bool:
        """Whether stability is lost, or a pole moves by a tenth of its distance to the boundary.

        Where rounding is fatal, the rounded poles are so ill-conditioned that their isolation takes
        long; the coefficients, and the poles before, decide in most cases.
        """
        if self.is_lost or self._known_far:
            return True
        return not stay_close(self.target, self.rounded) and self.share > DANGEROUS_SHARE

    @property
    def is_lost(self) -> bool:
        """Whether a stable loop becomes unstable."""
        return self.was_stable and not self.is_stable

    @cached_property
    def _known_far(self) -> bool:
        return are_far(self.target, self.rounded)

    @cached_property
    def _largest_move(self) -> tuple[float, float]:
        before, after = certified_roots(self.target), certified_roots(self.rounded)
        return _largest_move(before, after, self.target.gen)

    def __str__(self) -> str:
        if self.is_lost:
            return "rounding moves a closed-loop pole across the boundary: the loop is UNSTABLE"
        if self._known_far:
            return "rounding moves a closed-loop pole farther than it was from the boundary"
        return (
            f"rounding moves a closed-loop pole by {self.displacement:.2g}, that is "
            f"{self.share:.2g} of its distance to the stability boundary"
        )


def rounding_effect(
    plant: TransferFunction, compensator: TransferFunction, *, feedback: int
) -> RoundingEffect:
    r"""Round a compensator once and follow the closed-loop poles exactly.

    .. math:: \tilde D = D D_c - f N N_c, \qquad
              \tilde D_{64} = D\,\mathrm{fl}(D_c) - f N\,\mathrm{fl}(N_c)
    """
    rounded = TransferFunction(
        rounded_polynomial(compensator.numerator), rounded_polynomial(compensator.denominator)
    )
    exact, moved = (closed_loop_of_pair(plant, G_c, feedback) for G_c in (compensator, rounded))
    is_discrete(plant.variable, "the distance to the stability boundary")
    return RoundingEffect(exact, moved, is_stable(exact), is_stable(moved))


def rounded_polynomial(poly: Poly) -> Poly:
    """Round every coefficient to float64 and return the exact polynomial that results."""
    if not is_rational(poly):
        raise InputError(
            f"{quoted(poly)} has coefficients that are not rational; {way_to_rational(poly)} "
            "before rounding"
        )
    try:
        coefficients = [int(c.p) / int(c.q) for c in poly.all_coeffs()]
    except OverflowError as error:
        raise InputError(f"a coefficient of {quoted(poly)} overflows float64") from error
    return canonical(Poly([exact_number(c, binary=True) for c in coefficients], poly.gen))


def is_stable(poly: Poly) -> bool:
    """Tell whether a closed-loop polynomial is Schur in z or q, Hurwitz in s."""
    time = time_of(poly.gen, "stability")
    return bool(count_roots(poly, time=time).stable == poly.degree())


def _largest_move(
    before: tuple[Root, ...], after: tuple[Root, ...], variable: Symbol
) -> tuple[float, float]:
    displacement = share = 0.0
    discrete = is_discrete(variable, "the distance to the stability boundary")
    for root in after:
        nearest = min(before, key=lambda old: abs(old.value - root.value))
        distance = max(0.0, abs(nearest.value - root.value) - nearest.radius - root.radius)
        value = nearest.value
        room = abs(1 - abs(value)) if discrete else abs(value.real)
        displacement = max(displacement, distance)
        if room > 0:
            share = max(share, distance / room)
    return displacement, share


# How far the roots of two polynomials are apart, decided without isolating those of the second.


def stay_close(before: Poly, after: Poly) -> bool:
    r"""Prove that no pole moves by a tenth of its distance to the boundary, or return False.

    All roots of the monic rounded polynomial lie in the disks around the exact ones with radius
    :math:`r_i = n |\Delta p(\lambda_i)/p'(\lambda_i)|` (B. T. Smith, Journal of the ACM 17, 1970).
    The exact pole nearest to a rounded one may be another, at most 2 r nearer to the boundary: a
    twelfth leaves a tenth.
    """
    if before.degree() != after.degree():
        return False
    discrete = is_discrete(before.gen, "the distance to the stability boundary")
    exact, moved = (to_flint_polynomial(monic(p)) for p in (before, after))
    balls = root_balls(before)
    with ball_precision(128):
        change, slope = flint.acb_poly(moved - exact), flint.acb_poly(exact.derivative())
        for ball, multiplicity in balls:
            room = abs(1 - abs(ball)) if discrete else abs(ball.real)
            steep = slope(ball)
            if multiplicity > 1 or not abs(steep) > 0:
                return False
            if not len(balls) * abs(change(ball) / steep) < room / 12:
                return False
    return True


def are_far(before: Poly, after: Poly) -> bool:
    r"""Prove from the coefficients that a pole moves farther than any was from the boundary.

    .. math:: |c_{n-k}| \le \binom nk \max_i |\mu_i|^k, \qquad
              \max_i |\lambda_i| \le 2 \max_k |a_{n-k}|^{1/k}
    """
    if before.degree() != after.degree():
        return False
    with ball_precision(64):
        (old, new), n = (_magnitudes(p) for p in (before, after)), int(before.degree())
        reach = 1 + 2 * max((c.root(k) for k, c in enumerate(old, 1)), default=flint.arb(0))
        farthest = max(((c / comb(n, k)).root(k) for k, c in enumerate(new, 1)), default=reach)
        return bool(farthest > 3 * reach)  # the distances from 0 and from the boundary are within


def _magnitudes(poly: Poly) -> list[flint.arb]:
    """Return |a_(n-1)|, ..., |a_0| of the monic multiple."""
    return [abs(flint.arb(c)) for c in to_flint_polynomial(monic(poly)).coeffs()[-2::-1]]
