"""How far the roots of two polynomials are apart, decided without isolating those of the second."""

from math import comb

import flint
from sympy import Poly

from compensator_theory.matrices.flint_polynomials import to_flint_polynomial
from compensator_theory.polynomials.ball_precision import ball_precision
from compensator_theory.polynomials.poly import monic
from compensator_theory.polynomials.variables import is_discrete
from compensator_theory.roots.certified import root_balls


def stay_close(before: Poly, after: Poly) -> bool:
    r"""Prove that no pole moves by a tenth of its distance to the boundary, or return False.

    All roots of the monic rounded polynomial lie in the disks around the exact ones with radius
    :math:`r_i = n |\Delta p(\lambda_i)/p'(\lambda_i)|` (B. T. Smith, Journal of the ACM 17, 1970).
    The exact pole nearest to a rounded one may be another, at most 2 r nearer to the boundary: a
    twelfth leaves a tenth.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.placement.displacement_bounds import stay_close
    >>> stay_close(polynomial("s**2 + 3*s + 2"), polynomial("s**2 + 3.001*s + 2"))
    True
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

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.placement.displacement_bounds import are_far
    >>> are_far(polynomial("s**2 + 3*s + 2"), polynomial("s**2 + 99*s + 2"))
    True
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
