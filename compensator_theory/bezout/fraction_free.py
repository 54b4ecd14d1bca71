"""Greatest common divisors over rational functions, and their identities, without fractions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import flint
from sympy.polys.domains.domain import Domain
from sympy.polys.rings import PolyRing

from compensator_theory.polynomials.budget import ask

_Mpoly: TypeAlias = flint.fmpq_mpoly
Element: TypeAlias = Any
"""Of a ring of SymPy in the variable, over a field of rational functions."""
Grid: TypeAlias = list[list[Element]]


class FractionFree:
    """Elements of a symbolic ring as polynomials of python-flint in the variable and the symbols.

    Examples
    --------
    >>> from sympy import QQ
    >>> from sympy.abc import a, b, s
    >>> from sympy.polys.rings import PolyRing
    >>> from compensator_theory.bezout.fraction_free import FractionFree
    >>> ring = PolyRing([s], QQ.frac_field(a, b), "lex")
    >>> p, q = ring.from_expr(s * (s + a)), ring.from_expr(s * (s + b))
    >>> x, y, first, second = FractionFree(ring).identity(p, q)
    >>> x * p + y * q, first
    (s, s + a)
    """

    def __init__(self, ring: PolyRing) -> None:
        self.ring = ring
        count = 1 + len(ring.domain.symbols)
        names = [f"x{i}" for i in range(count)]
        self.context = flint.fmpq_mpoly_ctx.get(names, flint.Ordering.lex)

    @staticmethod
    def serves(field: Domain) -> bool:
        """Tell whether a field holds the rational functions of symbols over QQ."""
        return bool(field.is_FractionField and field.domain.is_QQ)

    def degree_of_gcd(self, elements: Sequence[Element]) -> int:
        """Return the degree of the greatest common divisor, -1 if all are zero."""
        common = self.context.constant(0)
        for element in elements:
            if element:
                common = common.gcd(self._cleared(element)[0])
                if common.degrees()[0] == 0:
                    return 0
        return -1 if common.is_zero() else int(common.degrees()[0])

    def identity(self, p: Element, q: Element) -> tuple[Element, Element, Element, Element]:
        """Return x, y, a, b with x p + y q = g, p = a g, q = b g and x a + y b = 1."""
        (P, below_p), (Q, below_q) = self._cleared(p), self._cleared(q)
        common = P.gcd(Q)
        content = self._content(self._coefficients(common))
        common = common / content
        A, B = P / common, Q / common
        X, Y, r = self._multipliers(self._coefficients(A), self._coefficients(B))
        a = self._element(self._coefficients(A), below_p)
        b = self._element(self._coefficients(B), below_q)
        x = self._element([c * below_p for c in X], r)
        y = self._element([c * below_q for c in Y], r)
        return x, y, a, b

    def product(
        self, left: Sequence[Sequence[Element]], columns: Sequence[Sequence[Element]]
    ) -> Grid:
        """Multiply matrices with one common denominator for each row and for each column."""
        others = [self._over_one(column) for column in columns]
        result: Grid = []
        for row, below in map(self._over_one, left):
            result.append([])
            for column, under in others:
                total = self.context.constant(0)
                for x, y in zip(row, column, strict=True):
                    total += x * y
                result[-1].append(self._element(self._coefficients(total), below * under))
        return result

    def _over_one(self, elements: Sequence[Element]) -> tuple[list[_Mpoly], _Mpoly]:
        pairs = [self._cleared(element) for element in elements]
        common = self._common(below for _, below in pairs)
        return [above * (common / below) for above, below in pairs], common

    def _common(self, denominators: Iterable[_Mpoly]) -> _Mpoly:
        """Return a least common multiple."""
        common = self.context.constant(1)
        for below in denominators:
            common = common * (below / common.gcd(below))
        ask("terms", len(common), "a common denominator")
        return common

    def _multipliers(
        self, A: list[_Mpoly], B: list[_Mpoly]
    ) -> tuple[list[_Mpoly], list[_Mpoly], _Mpoly]:
        """Return X, Y and r, without the variable, with X A + Y B = r; ascending coefficients."""
        m, n = len(A) - 1, len(B) - 1
        one, zero = self.context.constant(1), self.context.constant(0)
        if m == 0 or n == 0:
            return ([one], [], A[0]) if m == 0 else ([], [one], B[0])
        rows = []
        for power in range(m + n):
            row = [A[power - j] if 0 <= power - j <= m else zero for j in range(n)]
            row += [B[power - j] if 0 <= power - j <= n else zero for j in range(m)]
            rows.append([*row, one if power == 0 else zero])
        determinant = self._solved(rows)
        values = [row[-1] for row in rows]
        shared = self._content([determinant, *values])
        values = [value / shared for value in values]
        return values[:n], values[n:], determinant / shared

    def _solved(self, rows: list[list[_Mpoly]]) -> _Mpoly:
        """Solve in place by Bareiss's method; the last column times 1/determinant is the answer."""
        before = self.context.constant(1)
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

    def _cleared(self, element: Element) -> tuple[_Mpoly, _Mpoly]:
        """Return the element times a common denominator, and that denominator."""
        pairs = {power: self._pair(c) for (power,), c in element.items()}
        common = self._common(below for _, below in pairs.values())
        s = self.context.gens()[0]
        total = self.context.constant(0)
        for power, (above, below) in pairs.items():
            total += above * (common / below) * s**power
        return total, common

    def _pair(self, fraction: Element) -> tuple[_Mpoly, _Mpoly]:
        above, below = (
            self.context.from_dict({
                (0, *powers): flint.fmpq(int(c.numerator), int(c.denominator))
                for powers, c in side.items()
            })
            for side in (fraction.numer, fraction.denom)
        )  # fmt: skip
        return above, below

    def _coefficients(self, poly: _Mpoly) -> list[_Mpoly]:
        """Return the coefficients of ascending powers of the variable."""
        found: list[dict[tuple[int, ...], flint.fmpq]] = [
            {} for _ in range(int(poly.degrees()[0]) + 1)
        ]
        for (power, *others), c in poly.to_dict().items():
            found[int(power)][0, *others] = c
        return [self.context.from_dict(terms) for terms in found]

    def _content(self, polys: Sequence[_Mpoly]) -> _Mpoly:
        common = self.context.constant(0)
        for poly in polys:
            common = common.gcd(poly)
        return common

    def _element(self, coefficients: Sequence[_Mpoly], below: _Mpoly) -> Element:
        """Return the element with these ascending coefficients over one denominator."""
        field = self.ring.domain.field
        terms = {}
        for power, above in enumerate(coefficients):
            if not above.is_zero():
                shared = above.gcd(below)
                sides = (self._side(side / shared) for side in (above, below))
                terms[power,] = field.new(*sides)
        return self.ring.from_dict(terms)

    def _side(self, poly: _Mpoly) -> Element:
        ring = self.ring.domain.field.ring
        convert = ring.domain
        return ring.from_dict({
            tuple(map(int, powers[1:])): convert(int(c.p), int(c.q))
            for powers, c in poly.to_dict().items()
        })  # fmt: skip
