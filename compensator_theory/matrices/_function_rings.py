"""Polynomials in one variable over the rational functions of symbols, by python-flint."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import flint
from sympy import Expr, Poly, Symbol
from sympy.polys.domains.domain import Domain

from compensator_theory.matrices._rational_functions import in_symbols
from compensator_theory.matrices._symbolic_matrices import common_factor
from compensator_theory.polynomials._budget import ask

_Mpoly: TypeAlias = flint.fmpz_mpoly


class Element:
    """A polynomial as coefficients by ascending powers over one denominator, in lowest terms."""

    __slots__ = ("above", "below", "ring")

    def __init__(self, ring: FunctionRing, above: list[_Mpoly], below: _Mpoly) -> None:
        while above and above[-1].is_zero():
            above.pop()
        if not below.is_one():
            shared = common_factor(below, above)
            if below.leading_coefficient() < 0:
                shared = -shared
            if not shared.is_one():
                above, below = [c / shared for c in above], below / shared
        self.ring, self.above, self.below = ring, above, below

    def __bool__(self) -> bool:
        return bool(self.above)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Element):
            return NotImplemented
        return self.above == other.above and self.below == other.below

    __hash__ = None  # type: ignore[assignment]

    def __neg__(self) -> Element:
        return Element(self.ring, [-c for c in self.above], self.below)

    def __add__(self, other: Element) -> Element:
        return self.ring.combined([(self, self.ring.one), (other, self.ring.one)])

    def __sub__(self, other: Element) -> Element:
        return self + -other

    def __mul__(self, other: Element | int) -> Element:
        if isinstance(other, int):
            return Element(self.ring, [c * other for c in self.above], self.below)
        return self.ring.combined([(self, other)])


class FunctionRing:
    """The ring of polynomials in a variable whose coefficients are rational functions over QQ."""

    def __init__(self, variable: Symbol, field: Domain) -> None:
        self.variable, self.work = variable, in_symbols(frozenset(field.symbols))
        self.zero = Element(self, [], self.work.one)
        self.one = Element(self, [self.work.one], self.work.one)
        names = [f"x{i}" for i in range(1 + len(self.work.symbols))]
        self.joint = flint.fmpz_mpoly_ctx.get(names, flint.Ordering.lex)
        self.moves = {f"x{i}": f"x{i + 1}" for i in range(len(self.work.symbols))}
        self.back = {after: before for before, after in self.moves.items()}

    @staticmethod
    def serves(field: Domain) -> bool:
        """Tell whether a domain holds polynomials or rational functions of symbols over QQ."""
        return bool(
            field.is_Composite
            and field.domain.is_QQ
            and all(isinstance(symbol, Symbol) for symbol in field.symbols)
        )

    def read(self, poly: Poly) -> Element:
        """Return an element."""
        domain = poly.domain
        pairs = [self._pair(domain, c) for c in reversed(poly.rep.to_list())]
        common = self._common(below for _, below in pairs)
        return Element(self, [above * (common / below) for above, below in pairs], common)

    def _pair(self, domain: Domain, coefficient: Any) -> tuple[_Mpoly, _Mpoly]:
        if domain.is_FractionField:
            (top, a), (bottom, b) = (
                self._side(domain.symbols, side) for side in (coefficient.numer, coefficient.denom)
            )
            return top * b, bottom * a
        if domain.is_PolynomialRing:
            top, below = self._side(domain.symbols, coefficient)
            return top, self.work.one * below
        value = domain.to_sympy(coefficient)
        return self.work.one * int(value.p), self.work.one * int(value.q)

    def _side(self, symbols: Sequence[Symbol], side: Any) -> tuple[_Mpoly, int]:
        """Return a polynomial of SymPy times a whole number, and that."""
        places = [symbols.index(x) if x in symbols else -1 for x in self.work.symbols]
        below = flint.fmpz(1)
        for c in side.values():
            below = below.lcm(int(c.denominator))
        terms = {
            tuple(int(powers[k]) if k >= 0 else 0 for k in places): int(c.numerator)
            * (int(below) // int(c.denominator))
            for powers, c in side.items()
        }
        return self.work.context.from_dict(terms), int(below)

    def write(self, element: Element) -> Poly:
        """Return a polynomial of SymPy."""
        pairs = [(c, element.below) for c in reversed(element.above)]
        return self.work.polynomial(pairs or [(self.work.zero, self.work.one)], self.variable)

    def degree(self, element: Element) -> int:
        """Return the degree, -1 for zero."""
        return len(element.above) - 1

    def terms(self, element: Element) -> int:
        """Return the number of terms of the coefficients, whose growth cannot be predicted."""
        return sum(map(len, element.above)) + len(element.below)

    def effort(self, a: Element, b: Element) -> int:
        """Return 0: the terms are counted at each division."""
        return 0

    def divide(self, a: Element, b: Element) -> tuple[Element, Element]:
        """Return quotient and remainder."""
        ask("terms", self.terms(a) + self.terms(b), "a division between polynomial matrices")
        rest, divisor, scale = list(a.above), b.above, self.work.one
        quotient = [self.work.zero] * max(0, len(rest) - len(divisor) + 1)
        for shift in reversed(range(len(quotient))):
            top = rest.pop()
            if top.is_zero():
                continue
            shared = top.gcd(divisor[-1])
            factor, top = divisor[-1] / shared, top / shared
            if not factor.is_one():
                rest, scale = [factor * c for c in rest], factor * scale
                quotient = [factor * c for c in quotient]
            quotient[shift] = top
            for k, c in enumerate(divisor[:-1], shift):
                rest[k] -= top * c
        below = scale * a.below
        return Element(self, [c * b.below for c in quotient], below), Element(self, rest, below)

    def reciprocal_of_leading(self, element: Element) -> Element:
        """Return 1 over the leading coefficient, as a constant polynomial."""
        return Element(self, [element.below], element.above[-1])

    def coefficient(self, element: Element, power: int) -> Element:
        """Return one coefficient, as a constant polynomial."""
        return Element(self, element.above[power : power + 1], element.below)

    def power(self, exponent: int) -> Element:
        """Return a power of the variable."""
        return Element(self, [self.work.zero] * exponent + [self.work.one], self.work.one)

    def combined(self, pairs: Iterable[tuple[Element, Element]]) -> Element:
        """Return a sum of products, over one denominator before it is brought to lowest terms."""
        terms = [(x, y, x.below * y.below) for x, y in pairs if x and y]
        common = self._common(below for _, _, below in terms)
        length = max((len(x.above) + len(y.above) - 1 for x, y, _ in terms), default=0)
        total = [self.work.zero] * length
        for x, y, below in terms:
            factor = common / below
            for i, c in enumerate(x.above):
                if not c.is_zero():
                    scaled = c if factor.is_one() else c * factor
                    for j, d in enumerate(y.above, i):
                        total[j] += scaled * d
        return Element(self, total, common)

    def _common(self, denominators: Iterable[_Mpoly]) -> _Mpoly:
        """Return a least common multiple."""
        common = self.work.one
        for below in denominators:
            if below != common:
                common = common * (below / common.gcd(below))
        ask("terms", len(common), "a common denominator")
        return common

    # Greatest common divisors and their identities, without fractions.

    def degree_of_gcd(self, elements: Iterable[Element]) -> int:
        """Return the degree of the greatest common divisor, -1 if all are zero."""
        common = self.joint.constant(0)
        for element in filter(None, elements):
            common = common.gcd(self._joined(element))
            if common.degrees()[0] == 0:
                return 0
        return -1 if common.is_zero() else int(common.degrees()[0])

    def identity(self, p: Element, q: Element) -> tuple[Element, Element, Element, Element]:
        """Return x, y, a, b with x p + y q = g, p = a g, q = b g and x a + y b = 1."""
        P, Q = self._joined(p), self._joined(q)
        common = P.gcd(Q)
        content = self._content(self._coefficients(common))
        common = common / content.project_to_context(self.joint, self.moves)
        A, B = self._coefficients(P / common), self._coefficients(Q / common)
        X, Y, r = self._multipliers(A, B)
        x, y = (
            Element(self, [c * p.below for c in X], r),
            Element(self, [c * q.below for c in Y], r),
        )
        return x, y, Element(self, A, p.below), Element(self, B, q.below)

    def lowest_terms(self, p: Element, q: Element) -> tuple[Element, Element]:
        """Return p and q monic and without common factors."""
        P, Q = self._joined(p), self._joined(q)
        common = P.gcd(Q)
        sides = (self._coefficients(side / common) for side in (P, Q))
        top, bottom = (Element(self, side, side[-1]) for side in sides)
        return top, bottom

    def resultant(self, p: Element, q: Element) -> Expr:
        """Return the resultant of the monic multiples of p and q."""
        P, Q = self._joined(p), self._joined(q)
        value = P.resultant(Q, "x0").project_to_context(self.work.context, self.back)
        leading = p.above[-1] ** self.degree(q) * q.above[-1] ** self.degree(p)
        return self.work.write(value, leading)

    def _joined(self, element: Element) -> _Mpoly:
        """Return the numerator as one polynomial in the variable and the symbols."""
        s, total = self.joint.gens()[0], self.joint.constant(0)
        for power, c in enumerate(element.above):
            total += c.project_to_context(self.joint, self.moves) * s**power
        return total

    def _coefficients(self, poly: _Mpoly) -> list[_Mpoly]:
        """Return the coefficients of ascending powers of the variable."""
        coefficients: list[dict[tuple[int, ...], flint.fmpz]] = [
            {} for _ in range(int(poly.degrees()[0]) + 1)
        ]
        for (power, *others), c in poly.to_dict().items():
            coefficients[int(power)][tuple(map(int, others))] = c
        return [self.work.context.from_dict(terms) for terms in coefficients]

    def _content(self, polys: Iterable[_Mpoly]) -> _Mpoly:
        return common_factor(self.work.zero, polys)

    def _multipliers(
        self, A: list[_Mpoly], B: list[_Mpoly]
    ) -> tuple[list[_Mpoly], list[_Mpoly], _Mpoly]:
        """Return X, Y and r, without the variable, with X A + Y B = r; ascending coefficients."""
        m, n = len(A) - 1, len(B) - 1
        one, zero = self.work.one, self.work.zero
        if m == 0 or n == 0:
            return ([one], [], A[0]) if m == 0 else ([], [one], B[0])
        rows = []
        for power in range(m + n):
            row = [A[power - j] if 0 <= power - j <= m else zero for j in range(n)]
            row += [B[power - j] if 0 <= power - j <= n else zero for j in range(m)]
            rows.append([*row, one if power == 0 else zero])
        determinant = self._solved(rows)
        values = [row[-1] for row in rows]
        return values[:n], values[n:], determinant

    def _solved(self, rows: list[list[_Mpoly]]) -> _Mpoly:
        """Solve in place by Bareiss's method; the last column times 1/determinant is the answer."""
        before = self.work.one
        for k in range(len(rows)):
            place = min(
                (i for i in range(k, len(rows)) if not rows[i][k].is_zero()),
                key=lambda i: len(rows[i][k]),
            )
            rows[k], rows[place] = rows[place], rows[k]
            pivot = rows[k][k]
            ask("terms", len(pivot), "the resultant of two entries")
            for i, row in enumerate(rows):
                if i != k:
                    head = row[k]
                    rows[i][k + 1 :] = [
                        (pivot * x - head * y) / before
                        for x, y in zip(row[k + 1 :], rows[k][k + 1 :], strict=True)
                    ]
            before = pivot
        return before
