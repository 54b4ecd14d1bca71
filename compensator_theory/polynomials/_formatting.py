"""Canonical form of a polynomial: the least coefficient domain, and text that reads back."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import sympy
from sympy import QQ, Poly, Symbol
from sympy.polys.domains.domain import Domain
from sympy.polys.polyclasses import DMP

from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import quoted


def format_polynomial(poly: Poly) -> str:
    """Write a polynomial in descending powers, as :func:`polynomial` reads it."""
    written = ""
    for power, coefficient in sorted(poly.as_dict().items(), reverse=True):
        unit = poly.gen ** power[0]
        if coefficient.is_Add:
            term = f"({text(coefficient)})" + (f"*{text(unit)}" if power[0] else "")
        else:
            term = text(coefficient * unit)
        sign, term = ("-", term[1:]) if term.startswith("-") else ("+", term)
        written += f" {sign} {term}"
    if not written:
        return "0"
    return written[3:] if written.startswith(" +") else "-" + written[3:]


def require_real(poly: Poly) -> None:
    """Refuse coefficients with the imaginary unit, whatever SymPy's domain for them is."""
    if any(value.has(sympy.I) for value in poly.all_coeffs()):
        raise InputError(
            f"{quoted(poly)} has complex coefficients, which certified_roots, count_roots, "
            "decide_stability, stability_conditions and partial_fractions read; others need real "
            "ones: write a rotating frame by its two real axes, a + jb as [[a, -b], [b, a]]. "
            "Complex roots of a real polynomial come in conjugate pairs"
        )


def in_least_domain(poly: Poly) -> Poly | None:
    """Return a polynomial over the smallest of QQ, QQ[a, ...] and QQ(a, ...) that contains it.

    SymPy's own ``retract`` writes every coefficient as an expression and reads it again.
    """
    domain = poly.domain
    if not (domain.is_PolynomialRing or domain.is_FractionField):
        return None
    if not (domain.domain.is_QQ or domain.domain.is_ZZ):
        return None
    if not all(isinstance(symbol, Symbol) for symbol in domain.symbols):
        return None
    used: set[int] = set()
    divides = False
    for numerator, denominator in _sides(poly):
        if domain.is_PolynomialRing and len(used) == len(domain.symbols):
            break
        for side in (numerator, denominator):
            for powers in side or ():
                used.update(i for i, power in enumerate(powers) if power)
        divides |= denominator is not None and not denominator.is_ground
    least = composite_domain(frozenset(domain.symbols[i] for i in used), divides=divides)
    if domain == least:
        return poly
    if least.is_FractionField:
        return poly.set_domain(least)
    places = [domain.symbols.index(symbol) for symbol in least.symbols] if used else []
    values = []
    for numerator, denominator in _sides(poly):
        ground = QQ.one if denominator is None else _rational(denominator.LC)
        terms = {tuple(p[i] for i in places): _rational(c) / ground for p, c in numerator.items()}
        values.append(least.ring.from_dict(terms) if used else terms.get((), QQ.zero))
    return Poly.new(DMP(values, least, 0), poly.gen)


def _rational(number: Any) -> Any:
    return QQ(int(number.numerator), int(number.denominator))


def _sides(poly: Poly) -> Iterator[tuple[Any, Any]]:
    for coefficient in poly.rep.to_list():
        if poly.domain.is_FractionField:
            yield coefficient.numer, coefficient.denom
        else:
            yield coefficient, None


@lru_cache(maxsize=256)
def composite_domain(symbols: frozenset[Symbol], *, divides: bool) -> Domain:
    """Return QQ[symbols], or QQ(symbols) if one divides, in SymPy's order; QQ without symbols."""
    if not symbols:
        return QQ
    ordered = Poly(sympy.Add(*symbols), domain=QQ).gens
    return QQ.frac_field(*ordered) if divides else QQ.poly_ring(*ordered)
