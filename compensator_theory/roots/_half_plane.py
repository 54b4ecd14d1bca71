"""The unit disk as a half plane: a polynomial in z as one in w with z = (1 + w)/(1 - w)."""

from __future__ import annotations

from sympy import Poly

from compensator_theory.polynomials._poly import canonical


def half_plane_polynomial(poly: Poly, size: int | None = None) -> Poly:
    r"""Map the open unit disk to the open left half plane.

    .. math:: q(w) = (1 - w)^n\, p\Big(\frac{1 + w}{1 - w}\Big), \qquad n \ge \deg p

    n is `size`, by default the degree.
    """
    w, ring = poly.gen, poly.domain
    plus, minus = (Poly([sign, 1], w, domain=ring) for sign in (1, -1))
    total, power = Poly(0, w, domain=ring), Poly(1, w, domain=ring)
    missing = 0 if size is None or poly.is_zero else size - int(poly.degree())
    for coefficient in [0] * missing + poly.all_coeffs():  # Horner's rule
        total = total * plus + power * Poly(coefficient, w, domain=ring)
        power *= minus
    return canonical(total)
