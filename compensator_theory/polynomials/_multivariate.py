"""Polynomials with symbols in their coefficients as polynomials of python-flint in all of them."""

from __future__ import annotations

import flint
from sympy import Poly
from sympy.polys.domains.domain import Domain


def flint_domain(*polys: Poly) -> Domain | None:
    """The ring QQ[symbols] of the coefficients of polynomials in one variable, or None."""
    first, *others = polys
    for other in others:
        first = first.unify(other)[0]
    domain = first.domain
    return domain if domain.is_PolynomialRing and domain.domain.is_QQ else None


def to_flint(domain: Domain, *polys: Poly) -> list[flint.fmpq_mpoly]:
    """Polynomials over a `flint_domain`; x0 is their variable, the others are its symbols."""
    names = [f"x{i}" for i in range(1 + len(domain.symbols))]
    context = flint.fmpq_mpoly_ctx.get(names, flint.Ordering.lex)
    return [
        context.from_dict({
            (power, *map(int, others)): flint.fmpq(int(c.numerator), int(c.denominator))
            for (power,), coefficient in poly.set_domain(domain).rep.to_dict().items()
            for others, c in coefficient.items()
        })
        for poly in polys
    ]  # fmt: skip


def coefficients_of(domain: Domain, polynomial: flint.fmpq_mpoly) -> dict[int, object]:
    """The coefficients of each power of x0, as elements of the domain."""
    ring = domain.ring
    terms: dict[int, dict[tuple[int, ...], object]] = {}
    for (power, *others), c in polynomial.to_dict().items():
        number = ring.domain(int(c.p), int(c.q))
        terms.setdefault(int(power), {})[tuple(map(int, others))] = number
    return {power: ring.from_dict(part) for power, part in terms.items()}


def common_divisor_by_flint(*polys: Poly) -> Poly | None:
    """A greatest common divisor over the field of the symbols; None where they have others.

    SymPy's heuristic gcd gives up on some of them with an error.
    """
    cleared = [
        poly.clear_denoms(convert=True)[1] if poly.domain.is_FractionField else poly
        for poly in polys
    ]
    domain = flint_domain(*cleared)
    if domain is None:
        return None
    first, *others = to_flint(domain, *cleared)
    for other in others:
        first = first.gcd(other)
    coefficients = coefficients_of(domain, first)
    return Poly({(power,): c for power, c in coefficients.items()}, polys[0].gen, domain=domain)
