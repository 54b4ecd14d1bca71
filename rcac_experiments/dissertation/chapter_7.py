"""Chapter 7 as it is printed, where the ledger of proofs has no case."""

from __future__ import annotations

from collections.abc import Iterator

from sympy import I, Poly, Rational, Symbol

import compensator_theory as exact

Facts = Iterator[tuple[str, bool]]
s = Symbol("s")


def common_factor_of_7_3() -> Facts:
    """The first compensator of Example 7.3, reduced; both pairs give s^2 + 2s + 1."""
    pair = exact.transfer_function("(-s - 1)/(s + 1)")
    yield "it has the common factor s + 1", pair.common_factor() == exact.polynomial("s + 1")
    plant = exact.transfer_function("1/(s + 2)")
    other = exact.transfer_function("(-2*s - 3)/(s + 2)")
    D, N = plant.denominator, plant.numerator
    loops = [D * G_c.denominator + N * G_c.numerator for G_c in (pair, other)]
    yield "both pairs give s^2 + 2s + 1", loops == [exact.polynomial("s**2 + 2*s + 1")] * 2


def complex_gains_of_7_6() -> Facts:
    """The factors of D~ of Example 7.6: two complex cubics, and no two real ones."""
    half, tenth = Rational(1, 2), Rational(1, 10)
    roots = [-half + tenth * I, -1 + half * I, -2 + I]
    p = Poly.from_list([1], s)
    for root in roots:
        p *= Poly(s - root, s, extension=I)
    q = Poly([c.conjugate() for c in p.all_coeffs()], s, extension=I)
    requested = exact.polynomial("((s + 0.5)**2 + 0.01)*((s + 1)**2 + 0.25)*((s + 2)**2 + 1)")
    product = [c.expand() for c in (p * q).all_coeffs()]
    yield "it is p times the conjugate of p, of degree 3 each", product == requested.all_coeffs()
    yield "it has no real root", exact.roots.number_of_real_roots(requested) == 0
