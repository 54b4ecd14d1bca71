"""Exact polynomials in one variable, in the canonical form in which equal ones compare equal."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy
from sympy import EX, QQ, Expr, Poly, Symbol
from sympy.polys.constructor import construct_domain
from sympy.polys.polyclasses import DMP
from sympy.polys.polyerrors import CoercionFailed, GeneratorsError, PolynomialError

from compensator_theory.errors import Advice, InputError
from compensator_theory.polynomials._algebraic import rationalised
from compensator_theory.polynomials._budget import ask, decimal_digits, quoted, repr_of, unlimited
from compensator_theory.polynomials._decidable import DEAD_TIME, require_decidable
from compensator_theory.polynomials._formatting import in_least_domain, require_real
from compensator_theory.polynomials._multivariate import common_divisor_by_flint
from compensator_theory.polynomials._numbers import exact_number
from compensator_theory.polynomials._quotients import Quotient, multiplied_out
from compensator_theory.polynomials._sympy_trees import (
    by_powers,
    irrational_parts,
    require_small_field,
    settled,
    tree_of,
)
from compensator_theory.polynomials._variables import (
    require_one_symbol_a_name,
)


def from_coefficients(descending: Sequence[Expr], variable: Symbol) -> Poly:
    """Return the polynomial with computed exact coefficients."""
    return _from_powers(dict(enumerate(map(sympy.sympify, reversed(descending)))), variable)


def from_expression(expression: Expr, variable: Symbol) -> Poly:
    """Return the polynomial that a SymPy expression without floats is, in canonical form."""
    with unlimited():
        quotient = multiplied_out(tree_of(expression), least_denominators=True)
        return from_quotient(quotient, variable)


def ask_for_coefficients(poly: Poly, degree: int, subject: str, unit: int = 120) -> None:
    """Refuse work that grows with the cube of a degree and with the digits of the coefficients.

    Each `unit` of these digits counts as an entry.
    """
    flat = poly.inject() if poly.domain.is_PolynomialRing else poly
    if not (flat.domain.is_ZZ or flat.domain.is_QQ):
        return
    whole = flat.clear_denoms(convert=True)[1]
    bits = max((abs(int(c)).bit_length() for c in whole.coeffs()), default=0)
    ask("entries", degree**3 * decimal_digits(bits) // unit, f"{subject}, {unit} digits as one,")


def canonical(poly: Poly) -> Poly:
    """Return the polynomial over the smallest of QQ, QQ[a, ...], QQ(a, ...) that contains it.

    Equal polynomials then compare equal, whatever they were computed from.
    """
    if len(poly.gens) > 1:
        raise InputError(f"{quoted(poly)} has several generators; say which is the variable")
    if poly.domain.is_QQ:
        return poly
    if poly.domain.is_FiniteField:
        raise InputError(
            f"{quoted(poly)} has coefficients in a finite field; rational ones are needed"
        )
    if not poly.domain.is_Exact or poly.domain.is_EX or poly.domain.is_EXRAW:
        return from_expression(exact_number(poly.as_expr()), poly.gen)
    require_one_symbol_a_name({*poly.free_symbols_in_domain, poly.gen})
    if (least := in_least_domain(poly)) is not None:
        return least
    require_real(poly)
    small = poly.retract() if poly.domain.is_Composite else poly
    domain = small.domain
    if domain.is_ZZ or (domain.is_Algebraic and all(c.is_Rational for c in small.all_coeffs())):
        return small.set_domain(QQ)
    if domain.is_Composite and not all(symbol.is_Symbol for symbol in domain.symbols):
        require_decidable(poly.all_coeffs())
        return Poly(poly.as_expr(), poly.gen, extension=True)  # sqrt(2) is no free generator
    return small


def over_one_field(*polys: Poly) -> tuple[Poly, ...]:
    r"""Return polynomials that are to be joined over one field where they are irrational.

    SymPy joins two algebraic fields coefficient by coefficient, with PSLQ over relations of at most
    ten digits, and raises CoercionFailed for :math:`10^{18}\,10^{3/4}` in Q(10^(3/8)). Where a
    field is made for all coefficients together, only its surds are related.
    """
    domains = {poly.domain for poly in polys}
    if any(domain.is_EX for domain in domains):
        require_decidable(c for poly in polys for c in poly.all_coeffs())
    if sum(domain.is_Algebraic for domain in domains) < 2:
        return polys
    coefficients = [poly.all_coeffs() for poly in polys]
    numbers = [number for row in coefficients for number in row]
    if any(number.free_symbols for number in numbers):
        return polys
    require_small_field(list(set().union(*map(irrational_parts, numbers))))
    domain, values = construct_domain(numbers, extension=True)
    left = iter(values)
    return tuple(
        Poly([next(left) for _ in row], poly.gen, domain=domain)
        for row, poly in zip(coefficients, polys, strict=True)
    )


def total(*polys: Poly) -> Poly:
    """Add polynomials in one variable, of whatever fields."""
    first, *others = over_one_field(*polys)
    return canonical(sum(others, first))


def product(a: Poly, b: Poly) -> Poly:
    """Multiply two polynomials, whose degrees together must be within the budget."""
    if not (a.is_zero or b.is_zero):
        ask("degree", int(a.degree()) + int(b.degree()), "the product")
    a, b = over_one_field(a, b)
    return canonical(a * b)


def exact_quotient(poly: Poly, divisor: Poly) -> Poly:
    """Divide exactly by a factor, over the field of both."""
    top, bottom = over_one_field(poly, divisor)
    top, bottom = top.unify(bottom)
    field = top.domain.get_field()
    return canonical(top.set_domain(field).exquo(bottom.set_domain(field)))


def over_coefficient_field(*polys: Poly) -> tuple[Poly, ...]:
    """Return polynomials over the field of all their coefficients, surds beside symbols included.

    SymPy has no domain of its own choice for sqrt(2) + a and writes it as an expression, which no
    polynomial over it can be factored in.
    """
    first, *others = over_one_field(*polys)
    for other in others:
        first = first.unify(other)[0]
    field = first.domain.get_field()
    if field.is_EX:
        coefficients = [c for poly in polys for c in poly.all_coeffs()]
        surds = sorted(set().union(*map(irrational_parts, coefficients)), key=str)
        symbols = sorted(set().union(*(c.free_symbols for c in coefficients)), key=str)
        try:
            field = QQ.algebraic_field(*surds).frac_field(*symbols)
            return tuple(Poly(poly.as_expr(), poly.gen, domain=field) for poly in polys)
        except (CoercionFailed, NotImplementedError, PolynomialError):
            raise InputError(
                "the coefficients span no supported number field; write symbols in place of "
                "irrational numbers"
            ) from None
    return tuple(poly.set_domain(field) for poly in polys)


def common_divisor(first: Poly, *others: Poly) -> Poly:
    """Return the monic greatest common divisor."""
    if not all(poly.domain.is_QQ for poly in (first, *others)):
        first, *others = over_one_field(first, *others)  # type: ignore[assignment]
        divisor = common_divisor_by_flint(first, *others)
        if divisor is not None:
            return monic(canonical(divisor))
    for other in others:
        first = first.gcd(other)
    return monic(canonical(first))


def monic(poly: Poly) -> Poly:
    r"""Divide a polynomial by its leading coefficient, :math:`a(s)/a_k`.

    Raises
    ------
    InputError
        If the polynomial is zero.

    Examples
    --------
    >>> from compensator_theory import monic, polynomial
    >>> monic(polynomial("2*s + 3"))
    Poly(s + 3/2, s, domain='QQ')
    """
    poly = require_poly(poly)
    if poly.is_zero:
        raise InputError("the zero polynomial has no monic multiple")
    if poly.is_monic:
        return poly
    return canonical(poly.set_domain(poly.domain.get_field()).monic())


def scaled(poly: Poly, factor: Expr) -> Poly:
    """Multiply a polynomial by a number or by an expression in other symbols."""
    number = sympy.sympify(factor)
    if number is sympy.S.One:
        return canonical(poly)
    if number.is_Rational and poly.domain.is_QQ:
        return poly.mul_ground(QQ(int(number.p), int(number.q)))
    return canonical(poly * from_expression(number, poly.gen))


def require_poly(poly: Poly) -> Poly:
    """Return a polynomial over the rationals or over symbols in canonical form."""
    if not isinstance(poly, Poly):
        raise InputError(f"{repr_of(poly)} is not a sympy.Poly; make one with polynomial(..., 's')")
    if not poly.domain.is_Exact:
        raise InputError(f"{quoted(poly)} is not exact; read it with polynomial(...) first")
    return canonical(poly)


def is_rational(poly: Poly) -> bool:
    """Tell whether every coefficient is a rational number."""
    if isinstance(poly, Poly) and poly.domain.is_EX:  # functions of symbols are shown in it
        return False
    return bool(require_poly(poly).domain.is_QQ)


def way_to_rational(*parts: Poly, sources: Iterable[object] = ()) -> str:
    """Return the advice for coefficients that have symbols or are irrational.

    The `exponentials` of a sampled plant among the sources define some of the symbols: the advice
    names the symbols of their values instead, so that no known number is requested.
    """
    values = {x: value for one in sources for x, value in getattr(one, "exponentials", ())}
    symbols = {symbol for part in parts for symbol in part.free_symbols_in_domain}
    unknown = {symbol for x in symbols for symbol in getattr(values.get(x), "free_symbols", {x})}
    if names := sorted(symbol.name for symbol in unknown):
        return f"substitute numbers for {', '.join(names)}"
    return "give rational numbers close to the irrational ones"


def sides_in(quotient: Quotient, variable: Symbol) -> tuple[Poly, Poly]:
    """Return numerator and denominator of a quotient as polynomials, common factors kept."""
    sides = quotient.polynomials(variable)
    if sides is not None:
        return sides
    top, bottom = (by_powers(side, variable) for side in quotient.sides())
    if top is None or bottom is None:
        raise InputError(
            f"{quoted(quotient.value())} is no quotient of polynomials in {variable}"
            f"{_dead_time_in(quotient.value(), variable)}"
        )
    return _from_powers(top, variable), _from_powers(bottom, variable)


def from_quotient(quotient: Quotient, variable: Symbol) -> Poly:
    """Return a quotient as a polynomial after cancellation; refuse a proper fraction."""
    reduced = quotient.reduced()
    sides = reduced.polynomials(variable)
    if sides is not None and sides[1].degree() == 0:
        return sides[0].quo_ground(sides[1].LC())
    top, bottom = (by_powers(side, variable) for side in reduced.sides())
    if top is not None and bottom is not None:
        if list(bottom) == [0]:
            return _from_powers({k: c / bottom[0] for k, c in top.items()}, variable)
        divisor = _from_powers(bottom, variable)  # irrational factors show only in a division
        exact, rest = _from_powers(top, variable).to_field().div(divisor)
        if rest.is_zero:
            return canonical(exact)
    raise InputError(
        f"{quoted(reduced.value())} is no polynomial in {variable}, nor equal to one; of a "
        "rational function give the numerator or the denominator",
        *_dead_time_in(reduced.value(), variable),
    )


def _dead_time_in(value: Expr, variable: Symbol) -> tuple[str | Advice, ...]:
    """Return the advice for a dead time written as an exponential of the variable."""
    delays = [one for one in value.atoms(sympy.exp) if variable in one.free_symbols]
    return ("; ", DEAD_TIME) if delays else ()


def _from_powers(powers: dict[int, Expr], variable: Symbol) -> Poly:
    if all(c.is_Rational for c in powers.values()):
        values = {(k,): QQ(int(c.p), int(c.q)) for k, c in powers.items() if c}
        return Poly.new(DMP.from_dict(values, 0, QQ), variable)
    require_one_symbol_a_name(set().union({variable}, *(c.free_symbols for c in powers.values())))
    require_decidable(powers.values())
    require_small_field(list(powers.values()))
    powers = {k: c if c.free_symbols else rationalised(c) for k, c in powers.items()}
    try:
        result = Poly({(k,): c for k, c in powers.items()}, variable, extension=True)
    except (PolynomialError, GeneratorsError, CoercionFailed, NotImplementedError) as error:
        whole = sum(c * variable**k for k, c in powers.items())
        raise InputError(
            f"the coefficients of {quoted(whole)} span no supported number field; write symbols "
            "in their place"
        ) from error
    if not result.domain.is_EX:
        return canonical(result)
    result = Poly({(k,): settled(c) for k, c in powers.items()}, variable, domain=EX)
    require_real(result)  # as canonical does: the echo may come by the other way
    return result
