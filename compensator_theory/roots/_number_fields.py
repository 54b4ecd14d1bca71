"""The number field of stable spectral factors: one generator for all of their coefficients."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import TypeAlias

import flint
import sympy
from sympy import QQ, Expr, ImmutableMatrix, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, table, words
from compensator_theory._printing import text
from compensator_theory.matrices._flint_matrices import rational
from compensator_theory.matrices._flint_polynomials import from_flint_polynomial
from compensator_theory.polynomials._ball_precision import (
    at_growing_precision,
    ball_precision,
)
from compensator_theory.polynomials._budget import limit_of
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._enclosures import Enclosure, enclosure_of_ball

SIGMA = Symbol("sigma")
LARGEST_FIELD = 32
"""Degree up to which equations are solved in a field where the budget `field_degree` is less."""

CONJUGATES = 24
"""Degree from which a linear system is solved at the conjugates."""

MOST_BITS = 50_000
"""Of the polynomial of all choices of roots; longer ones take minutes to factor."""

Grid: TypeAlias = list[list[flint.fmpq_poly]]


@dataclass(frozen=True)
class NumberField(ExactValue):
    r"""The rational numbers with one real algebraic number, the greatest real root of a polynomial.

    Attributes
    ----------
    minimal : sympy.Poly
        Monic and irreducible over the rational numbers, in :math:`\sigma`.

    Examples
    --------
    >>> from compensator_theory import solve_riccati
    >>> solution = solve_riccati([[0, 1], [0, 0]], [[0], [1]], Q=[[1, 0], [0, 0]], R=[[1]],
    ...     time="continuous")
    >>> print(solution.field)
    Q(sigma), sigma the greatest real root of sigma**2 - 2
    >>> solution.field.generator
    sqrt(2)
    """

    minimal: Poly

    @property
    def degree(self) -> int:
        """The dimension of the field over the rational numbers."""
        return int(self.minimal.degree())

    @property
    def generator(self) -> Expr:
        """The generator: a rational number, in square roots, or a CRootOf."""
        m = self.minimal
        if self.degree == 1:
            return -m.TC() / m.LC()
        if self.degree == 2:
            b, c = (sympy.sympify(x) for x in m.all_coeffs()[1:])
            return sympy.expand((-b + sympy.sqrt(b**2 - 4 * c)) / 2)
        if self.degree == 4 and not any(m.all_coeffs()[1::2]):
            b, c = (sympy.sympify(x) for x in m.all_coeffs()[2::2])
            return sympy.sqrt(sympy.expand((-b + sympy.sqrt(b**2 - 4 * c)) / 2))
        return sympy.CRootOf(m, int(m.count_roots()) - 1)

    def ball(self, bits: int) -> flint.arb:
        """Return a ball around the generator, at a working precision, with no other root in it."""
        with ball_precision(bits):
            roots = integral(self.minimal).complex_roots()
            return max((r.real for r, _ in roots if r.imag == 0), key=lambda r: r.mid())

    def __str__(self) -> str:
        if self.degree == 1:
            return "Q"
        return f"Q(sigma), sigma the greatest real root of {format_polynomial(self.minimal)}"

    def _repr_latex_(self) -> str:
        if self.degree == 1:
            return displayed(r"\mathbb{Q}")
        place = f"{words(' the greatest real root of ')} {latex(self.minimal)}"
        return displayed(r"\mathbb{Q}(\sigma)", rf"\sigma {place}")


@dataclass(frozen=True)
class FieldMatrix(ExactValue):
    r"""A matrix whose entries are polynomials in the generator of a number field.

    .. math:: X = \sum_{k=0}^{d-1} X_k\,\sigma^k

    Attributes
    ----------
    field : NumberField
    entries : tuple of rows of tuples of flint.fmpq
        Of each entry the coefficients of :math:`1, \sigma, \sigma^2, \ldots`, fewer than the degree
        of the field.
    """

    field: NumberField
    entries: tuple[tuple[tuple[flint.fmpq, ...], ...], ...]

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        return len(self.entries), len(self.entries[0]) if self.entries else 0

    @property
    def matrix(self) -> ImmutableMatrix:
        """The matrix in SymPy's numbers, with the generator as a radical or root."""
        length = max((len(entry) for row in self.entries for entry in row), default=0)
        generator = self.field.generator if length > 1 else sympy.Integer(1)
        powers = [generator**k for k in range(length)]

        def written(entry: tuple[flint.fmpq, ...]) -> Expr:
            terms = (rational(c) * power for c, power in zip(entry, powers, strict=False))
            written = sympy.Add(*terms)
            return sympy.expand(written) if self.field.degree <= 4 else written

        rows, columns = self.shape
        return ImmutableMatrix(rows, columns, [written(e) for row in self.entries for e in row])

    @property
    def written(self) -> ImmutableMatrix | None:
        """The matrix in SymPy's numbers, or None if SymPy cannot compute with it.

        Above degree 32, or the budget of it, SymPy isolates the generator for minutes whenever a
        number is printed or compared; rational entries have no generator.
        """
        is_rational = all(len(entry) <= 1 for row in self.entries for entry in row)
        most = max(LARGEST_FIELD, limit_of("field_degree"))
        return self.matrix if is_rational or self.field.degree <= most else None

    @property
    def polynomials(self) -> tuple[tuple[Poly, ...], ...]:
        """The entries as polynomials in the generator."""
        return tuple(
            tuple(from_flint_polynomial(flint.fmpq_poly(list(e)), SIGMA) for e in row)
            for row in self.entries
        )

    def enclosures(self, digits: int = 30) -> tuple[tuple[Enclosure, ...], ...]:
        r"""Return balls around the entries, of radii of at most :math:`10^{-\mathrm{digits}}`."""
        goal = Rational(1, 10**digits)

        def attempt(bits: int) -> tuple[tuple[Enclosure, ...], ...] | None:
            place = self.field.ball(bits)
            enclosures = tuple(
                tuple(enclosure_of_ball(flint.arb_poly(list(e))(place)) for e in row)
                for row in self.entries
            )
            return enclosures if all(e.radius <= goal for row in enclosures for e in row) else None

        return at_growing_precision(attempt, 64 + 4 * digits, f"entries with {digits} digits")

    def __str__(self) -> str:
        if self.field.degree <= 4:
            return text(self.matrix.tolist())
        rows = [", ".join(format_polynomial(p) for p in row) for row in self.polynomials]
        return "[" + ", ".join(f"[{row}]" for row in rows) + "]"

    def _repr_latex_(self) -> str:
        if self.field.degree <= 4:
            return displayed(latex(self.matrix))
        rows = [[p.as_expr() for p in row] for row in self.polynomials]
        return displayed(table(rows))


def integral(poly: Poly) -> flint.fmpz_poly:
    """Return the primitive integer polynomial with the roots of a rational one."""
    whole = poly.set_domain(QQ).clear_denoms(convert=True)[1]
    return flint.fmpz_poly([int(c) for c in reversed(whole.all_coeffs())])


def field_matrix(field: NumberField, grid: Grid) -> FieldMatrix:
    """Return a matrix of polynomials in the generator as a value that compares and pickles."""
    return FieldMatrix(field, tuple(tuple(tuple(e.coeffs()) for e in row) for row in grid))


def grid_of(matrix: FieldMatrix) -> Grid:
    """Return the entries as polynomials of python-flint."""
    return [[flint.fmpq_poly(list(e)) for e in row] for row in matrix.entries]


class Arithmetic:
    """Matrices over a number field, as grids of polynomials in its generator."""

    def __init__(self, field: NumberField) -> None:
        self.field = field
        self.minimal = flint.fmpq_poly(integral(field.minimal))

    def of(self, matrix: flint.fmpq_mat) -> Grid:
        """Return a rational matrix as a grid."""
        return [[flint.fmpq_poly([entry]) for entry in row] for row in matrix.tolist()]

    def product(self, left: Grid, right: Grid) -> Grid:
        """Multiply two matrices."""
        columns = list(zip(*right, strict=True))
        zero = flint.fmpq_poly()
        return [
            [sum((a * b for a, b in zip(row, column, strict=True)), zero) % self.minimal
             for column in columns]
            for row in left
        ]  # fmt: skip

    def solve(self, matrix: Grid, right: Grid, scale: flint.fmpz | None = None) -> Grid:
        """Solve a square system: a rational one of d times the size, or one at each conjugate."""
        d, n, m = self.field.degree, len(matrix), len(right[0])
        if scale is not None and d >= CONJUGATES:
            return self._solve_at_conjugates(matrix, right, scale)
        system = flint.fmpq_mat(n * d, n * d)
        for i, row in enumerate(matrix):
            for j, entry in enumerate(row):
                column = entry
                for k in range(d):
                    for power, coefficient in enumerate(column.coeffs()):
                        system[i * d + power, j * d + k] = coefficient
                    column = column.left_shift(1) % self.minimal
        columns = flint.fmpq_mat(n * d, m)
        for i, row in enumerate(right):
            for j, entry in enumerate(row):
                for power, coefficient in enumerate(entry.coeffs()):
                    columns[i * d + power, j] = coefficient
        solution = system.solve(columns)
        return [
            [flint.fmpq_poly([solution[i * d + k, j] for k in range(d)]) for j in range(m)]
            for i in range(n)
        ]

    def _solve_at_conjugates(self, matrix: Grid, right: Grid, scale: flint.fmpz) -> Grid:
        """Round det X and det X times the solution, integers at all conjugates, from balls."""
        determinant, entries = at_growing_precision(
            lambda _: self._rounded(matrix, right, scale), 1024, "integers of a number field"
        )
        if not determinant:
            raise ZeroDivisionError
        reciprocal = inverse(determinant, self.minimal)
        return [[e * reciprocal % self.minimal for e in row] for row in entries]

    def _rounded(
        self, matrix: Grid, right: Grid, scale: flint.fmpz
    ) -> tuple[flint.fmpq_poly, Grid] | None:
        n, m = len(matrix), len(right[0])
        whole = integral(self.field.minimal)
        places = [r for r, _ in whole.complex_roots()]
        rows = []
        for y in places:
            left, right_side = (
                flint.acb_mat([[flint.acb_poly(e)(y) * scale for e in row] for row in grid])
                for grid in (matrix, right)
            )
            determinant = left.det()
            try:
                solved = left.solve(right_side)
            except ZeroDivisionError:
                return None if determinant.contains(0) and flint.ctx.prec < 1 << 16 else (
                    flint.fmpq_poly(), right)  # fmt: skip
            rows.append([determinant, *(e * determinant for e in solved.entries())])
        product = flint.acb_mat(rows).transpose() * flint.acb_mat(
            [_divided(whole, y) for y in places]
        )
        slope = inverse(self.minimal.derivative(), self.minimal)
        coefficients = []
        for k in range(n * m + 1):
            integers = [product[k, j].unique_fmpz() for j in range(len(places))]
            if any(c is None for c in integers):
                return None
            coefficients.append(flint.fmpq_poly(integers) * slope % self.minimal)
        return coefficients[0], [coefficients[1 + i * m : 1 + (i + 1) * m] for i in range(n)]


def plus(*grids: Grid) -> Grid:
    """Add matrices entry by entry."""
    zero = flint.fmpq_poly()
    return [[sum(entries, zero) for entries in zip(*rows, strict=True)]
            for rows in zip(*grids, strict=True)]  # fmt: skip


def times(left: flint.fmpq_mat, right: Grid) -> Grid:
    """Multiply by a rational matrix from the left."""
    zero = flint.fmpq_poly()
    columns = transposed(right)
    return [
        [sum((e * a for a, e in zip(row, column, strict=True)), zero) for column in columns]
        for row in left.tolist()
    ]


def by(left: Grid, right: flint.fmpq_mat) -> Grid:
    """Multiply by a rational matrix from the right."""
    return transposed(times(right.transpose(), transposed(left)))


def characteristic_data(
    A: Grid, B: Grid, C: Grid, work: Arithmetic
) -> tuple[list[flint.fmpq_poly], list[Grid]]:
    """Return det(sI - A), and C adj(sI - A) B as n matrices; powers of s descend."""
    n, zero = len(A), flint.fmpq_poly()
    descending, coefficients = [flint.fmpq_poly([1])], []
    power = [[flint.fmpq_poly([int(i == j)]) for j in range(n)] for i in range(n)]
    for k in range(1, n + 1):  # Faddeev and LeVerrier
        coefficients.append(work.product(C, work.product(power, B)))
        power = work.product(A, power)
        trace = sum((power[i][i] for i in range(n)), zero)
        c = trace * flint.fmpq(-1, k) % work.minimal
        descending.append(c)
        power = plus(power, [[c if i == j else zero for j in range(n)] for i in range(n)])
    return descending, coefficients


def transposed(grid: Grid) -> Grid:
    """Exchange rows and columns."""
    return [list(column) for column in zip(*grid, strict=True)]


@dataclass(frozen=True, eq=False)
class StableFactors:
    """The monic Hurwitz factors of even polynomials, over one field.

    Attributes
    ----------
    field : NumberField
    factors : list of lists of flint.fmpq_poly
        For each polynomial the coefficients of its factor, ascending, in the generator.
    irrational : flint.fmpq_poly
        The product of the distinct irreducible parts of all polynomials that do not split.
    scale : flint.fmpz
        The generator is minus the sum of the left roots of `irrational`, times this.
    """

    field: NumberField
    factors: list[list[flint.fmpq_poly]]
    irrational: flint.fmpq_poly
    scale: flint.fmpz


def stable_factors(*spectra: flint.fmpq_poly, most: int = LARGEST_FIELD) -> StableFactors | None:
    r"""Find the field of the Hurwitz factors of even polynomials, and their coefficients in it.

    Of all choices of one root from each pair :math:`\pm r_i`, the sum of those on the left, and of
    no other, has the least real part. So minus that sum is real and a *simple* root, the greatest
    real one, of :math:`M(y) = \prod (y - \sum \pm r_i)`, and an automorphism that keeps it keeps
    every left root in its place: it generates the field of all coefficients of all factors.
    """
    parts = [_parts(p) for p in spectra]
    distinct: list[flint.fmpz_poly] = []
    for _, pairs in parts:
        distinct += [f for f, _ in pairs if f not in distinct]
    if not distinct:
        field = NumberField(Poly(SIGMA, SIGMA, domain=QQ))
        factors = [[flint.fmpq_poly([c]) for c in rest.coeffs()] for rest, _ in parts]
        return StableFactors(field, factors, flint.fmpq_poly([1]), flint.fmpz(1))
    most = max(most, limit_of("field_degree"))
    half = sum(f.degree() for f in distinct) // 2
    whole = reduce(lambda a, b: a * b, distinct)
    scale = abs(whole.coeffs()[-1])
    bits = 128 + 2**half * (8 + 2 * int(scale).bit_length())
    if half > (2 * most).bit_length() - 1 or bits > MOST_BITS:
        return None
    minimal, factors = at_growing_precision(
        lambda _: _generated(parts, distinct, scale, most), bits, "the field of the stable roots"
    )
    if minimal.degree() > most:
        return None
    field = NumberField(from_flint_polynomial(flint.fmpq_poly(minimal), SIGMA))
    result = StableFactors(field, factors, flint.fmpq_poly(whole), scale)
    for p, factor in zip(spectra, factors, strict=True):
        _require_factor(p, factor, flint.fmpq_poly(minimal))
    return result


Pairs: TypeAlias = list[tuple[flint.fmpz_poly, int]]


def _parts(p: flint.fmpq_poly) -> tuple[flint.fmpq_poly, Pairs]:
    """Return the rational Hurwitz part, and even polynomials with powers that have the rest."""
    rest, pairs = flint.fmpq_poly([1]), []
    for factor, power in p.numer().factor()[1]:
        mirrored = flint.fmpz_poly([-c if k % 2 else c for k, c in enumerate(factor.coeffs())])
        is_even = mirrored in (factor, -factor)
        left = 0 if is_even else _number_left_of_axis(factor)
        if left == factor.degree():
            monic = flint.fmpq_poly(factor)
            rest *= (monic / monic.coeffs()[-1]) ** int(power)
        elif is_even:
            pairs.append((factor, int(power)))
        elif left > 0:  # roots on both sides; the mirrored factor has the others
            product = factor * mirrored
            if all(product not in (f, -f) for f, _ in pairs):
                pairs.append((product, int(power)))
    return rest, pairs


def _number_left_of_axis(factor: flint.fmpz_poly) -> int:
    def attempt(_: int) -> int | None:
        sides = [(r.real < 0, r.real > 0) for r, _ in factor.complex_roots()]
        return sum(bool(left) for left, _ in sides) if all(map(any, sides)) else None

    return at_growing_precision(attempt, 64, "the side of a root")  # one on the axis: is even


def _left_roots(factor: flint.fmpz_poly) -> list[flint.acb] | None:
    roots = [r for r, _ in factor.complex_roots()]
    left = [r for r in roots if r.real < 0]
    return left if len(left) == factor.degree() // 2 else None


def _generated(
    parts: Sequence[tuple[flint.fmpq_poly, Pairs]],
    distinct: Sequence[flint.fmpz_poly],
    scale: flint.fmpz,
    most: int,
) -> tuple[flint.fmpz_poly, list[list[flint.fmpq_poly]]] | None:
    """Compute at the current precision; None where it does not suffice."""
    roots = [_left_roots(f) for f in distinct]
    if any(root_list is None for root_list in roots):
        return None
    groups = [[r * scale for r in root_list or ()] for root_list in roots]
    flat = [r for group in groups for r in group]
    sums = [flint.acb(0)]
    for r in flat:
        sums = [y - r for y in sums] + [y + r for y in sums]
    # The entry with binary digits 0 at place i (from the last doubling) has the left root of i.
    M = flint.acb_poly.from_roots(sums).unique_fmpz_poly()
    if M is None:
        return None
    holding = [f for f, _ in M.factor()[1] if flint.acb_poly(f)(sums[0]).contains(0)]
    if len(holding) != 1:
        return None
    minimal = holding[0] if holding[0].coeffs()[-1] > 0 else -holding[0]
    d = int(minimal.degree())
    if d > most:
        return minimal, []
    places = [j for j, y in enumerate(sums) if flint.acb_poly(minimal)(y).contains(0)]
    if len(places) != d:
        return None
    signs = [[1 if not (j >> i) & 1 else -1 for i in range(len(flat))] for j in places]
    conjugates = [sums[j] for j in places]
    columns = [_divided(minimal, y) for y in conjugates]
    if any(c is None for c in columns):
        return None
    divided = flint.acb_mat(columns)
    starts, start = {}, 0
    for index, group in enumerate(groups):
        starts[index] = start
        start += len(group)
    generated = []
    for _, pairs in parts:
        chosen = [
            (starts[index] + i, r)
            for f, power in pairs
            for index, g in enumerate(distinct)
            if g == f
            for i, r in enumerate(groups[index])
            for _ in range(power)
        ]
        rows = [
            flint.acb_poly.from_roots([r * sign[i] for i, r in chosen]).coeffs() for sign in signs
        ]
        n = len(chosen)
        rows = [[*row, *[flint.acb(0)] * (n + 1 - len(row))] for row in rows]
        product = flint.acb_mat(rows).transpose() * divided
        whole = [[product[k, j].unique_fmpz() for j in range(d)] for k in range(n + 1)]
        if any(c is None for row in whole for c in row):
            return None
        generated.append(whole)
    minimal_q = flint.fmpq_poly(minimal)
    slope = inverse(minimal_q.derivative(), minimal_q)  # long: only where the integers are known
    factors = []
    for (rest, _), whole in zip(parts, generated, strict=True):
        irrational = [
            flint.fmpq_poly(row) * slope % minimal_q / (flint.fmpq(scale) ** (len(whole) - 1 - k))
            for k, row in enumerate(whole)
        ]
        factors.append(_convolved(irrational, rest.coeffs(), minimal_q))
    return minimal, factors


def _divided(minimal: flint.fmpz_poly, y: flint.acb) -> list[flint.acb]:
    """Return m(x)/(x - y), ascending."""
    descending = [flint.acb(c) for c in minimal.coeffs()[::-1]]
    quotient = [descending[0]]
    for c in descending[1:-1]:
        quotient.append(c + y * quotient[-1])
    return quotient[::-1]


def inverse(value: flint.fmpq_poly, minimal: flint.fmpq_poly) -> flint.fmpq_poly:
    """Return the reciprocal of an element of a field that is not zero."""
    if minimal.degree() == 1:
        return flint.fmpq_poly([1 / (value % minimal).coeffs()[0]])
    g, x, _ = value.xgcd(minimal)
    return x / g.coeffs()[0]


def _convolved(
    first: Sequence[flint.fmpq_poly], second: Iterable[flint.fmpq], minimal: flint.fmpq_poly
) -> list[flint.fmpq_poly]:
    other = list(second)
    product = [flint.fmpq_poly() for _ in range(len(first) + len(other) - 1)]
    for i, a in enumerate(first):
        for j, b in enumerate(other):
            product[i + j] += a * b
    return [c % minimal for c in product]


def _require_factor(
    p: flint.fmpq_poly, factor: Sequence[flint.fmpq_poly], minimal: flint.fmpq_poly
) -> None:
    """Multiply the factor by its mirror image, in the field."""
    mirrored = [-c if k % 2 else c for k, c in enumerate(factor)]
    coefficients = [flint.fmpq_poly() for _ in range(2 * len(factor) - 1)]
    for i, a in enumerate(factor):
        for j, b in enumerate(mirrored):
            coefficients[i + j] += a * b
    leading = p.coeffs()[-1] * (-1) ** (len(factor) - 1)
    product = [c * leading % minimal for c in coefficients]
    assert [c.coeffs() or [0] for c in product] == [[c] for c in p.coeffs()], "please report it"
