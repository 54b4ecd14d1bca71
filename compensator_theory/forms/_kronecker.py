"""Kronecker's canonical form of a pencil: minimal indices, finite and infinite structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import lcm
from typing import TypeAlias

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Integer, Poly, Symbol

from compensator_theory._latex import diagonal, displayed, latex, unless
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.forms._minimal_bases import (
    MinimalBasis,
    basis_of_pencil,
    minimal_basis,
)
from compensator_theory.forms._pencil_kernels import NullVectors, Pencil
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    polynomial_matrix,
)
from compensator_theory.forms._smith import smith_form
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import is_rational_matrix, to_flint
from compensator_theory.matrices._flint_polynomials import from_flint_polynomial
from compensator_theory.matrices._residues import pivots
from compensator_theory.matrices._symbolic_matrices import over_common_symbols
from compensator_theory.polynomials._budget import ask, decimal_digits
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._letters import variable_for_matrix
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue

# The regular part of a rational pencil, and its elementary divisors.

Orders: TypeAlias = list[tuple[flint.fmpq_poly, list[int]]]
"""Irreducible polynomials with their exponents in the elementary divisors, the largest first."""


def elementary_divisors(
    pencil: Pencil, right: NullVectors, left: NullVectors
) -> tuple[Orders, list[int]]:
    r"""Return the finite elementary divisors of a pencil, and the orders of its infinite ones.

    The coefficients of a minimal basis span a subspace that sE - A maps into one with a dimension
    less for each vector; the remaining block between both sides is the regular part, and with t =
    1/(s - c) it is t I - F for one matrix F, which has infinity at t = 0.
    """
    size = pencil.rank - _degrees(right) - _degrees(left)
    columns = _between(pencil.E, right, left)
    rows = _between(pencil.E.transpose(), left, right)
    regular = [rows.transpose() * part * columns for part in (pencil.R, pencil.E)]
    left_over = [
        x
        for part in (pencil.R, pencil.E)
        for a, b, block in ((rows, right, part), (columns, left, part.transpose()))
        if b
        for x in (a.transpose() * block * _columns(b)).entries()
    ]
    if {rows.ncols(), columns.ncols()} != {size} or any(left_over):
        raise NoSolutionError("the parts of this pencil do not add up to its rank; report it")
    if not size:
        return [], []
    ask("entries", size**2 * (_digits(regular) // 4), "the regular part, four digits as an entry,")
    F = -regular[0].solve(regular[1])
    if regular[0] * F != -flint.fmpq_mat(regular[1]):
        raise NoSolutionError("the regular part of this pencil is not solved; report it")
    finite: Orders = []
    infinite: list[int] = []
    for factor, orders in _orders(F):
        if factor == flint.fmpq_poly([0, 1]):
            infinite = orders
        else:
            finite.append((_in_s(factor, pencil.point), orders))
    return finite, infinite


def invariant_polynomials(orders: Orders) -> list[flint.fmpq_poly]:
    """Return the products of elementary divisors that divide each other, the smallest first."""
    one = flint.fmpq_poly([1])
    polynomials = [one] * max((len(exponents) for _, exponents in orders), default=0)
    for factor, exponents in orders:
        for k, exponent in enumerate(exponents):
            polynomials[k] *= factor**exponent
    return polynomials[::-1]


def _degrees(vectors: NullVectors) -> int:
    return sum(len(vector) - 1 for vector in vectors)


def _digits(regular: Sequence[flint.fmpz_mat]) -> int:
    """Bound the digits of a minor by Hadamard's inequality."""
    rows = zip(*(matrix.tolist() for matrix in regular), strict=True)
    squares = (sum(int(x) ** 2 for part in row for x in part) for row in rows)
    return sum(decimal_digits(square.bit_length()) for square in squares) // 2


def _columns(vectors: NullVectors) -> flint.fmpz_mat:
    """Return the coefficient matrices joined in one row of blocks."""
    columns = [list(column) for vector in vectors for column in vector]
    return flint.fmpz_mat(columns).transpose()


def _between(E: flint.fmpz_mat, right: NullVectors, left: NullVectors) -> flint.fmpz_mat:
    """Return columns x with l (sE - A) x = 0 for all left vectors l, modulo the right vectors.

    As l_k A is l_(k-1) E, and l E = 0 for the highest coefficient, all but that one and E are
    enough.
    """
    size = E.ncols()
    below = [list(row) for vector in left for row in vector[:-1]]
    unit = [[int(i == j) for j in range(size)] for i in range(size)]
    space = _kernel(flint.fmpz_mat(below) * E) if below else unit
    columns = [list(column) for vector in right for column in vector]
    both = pivots(flint.fmpz_mat([*columns, *space]).transpose())
    chosen = [space[k - len(columns)] for k in both if k >= len(columns)]
    return flint.fmpz_mat(chosen).transpose() if chosen else flint.fmpz_mat(size, 0)


def _kernel(matrix: flint.fmpz_mat) -> list[list[int]]:
    """Return a basis of the null space, in whole numbers without common factors."""
    basis, nullity = matrix.nullspace()
    return [_primitive(column) for column in basis.transpose().tolist()[:nullity]]


def _primitive(numbers: list[flint.fmpz]) -> list[int]:
    content = int(flint.fmpz_poly(numbers).content()) or 1
    return [int(x) // content for x in numbers]


def _orders(F: flint.fmpq_mat) -> Orders:
    """Return the elementary divisors of a matrix."""
    numerator, denominator = F.numer_denom()
    return [
        (
            factor,
            [1] if multiplicity == 1 else _exponents(numerator, denominator, factor, multiplicity),
        )
        for factor, multiplicity in F.charpoly().factor()[1]
    ]


def _exponents(
    numerator: flint.fmpz_mat, denominator: flint.fmpz, factor: flint.fmpq_poly, multiplicity: int
) -> list[int]:
    """Return the exponents of a factor f, the largest first, from the ranks of f(F), f(F)^2, ..."""
    size, degree = numerator.nrows(), factor.degree()
    unit = flint.fmpz_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])
    value, scale = unit * 0, 1
    for coefficient in reversed(factor.numer().coeffs()):  # Horner's rule, without fractions
        value, scale = value * numerator + unit * (coefficient * scale), scale * denominator
    value = _reduced(value)
    if len(pivots(value)) == size - degree:  # modulo a prime a rank is never too high
        return [multiplicity]
    power, rank = value, size
    heights: list[int] = []
    while sum(heights) < multiplicity:
        before, rank = rank, power.rank()
        heights.append((before - rank) // degree)
        power = _reduced(power * value)
    return [sum(height > k for height in heights) for k in range(heights[0])]


def _reduced(matrix: flint.fmpz_mat) -> flint.fmpz_mat:
    return flint.fmpz_mat(matrix.nrows(), matrix.ncols(), _primitive(matrix.entries()))


def _in_s(factor: flint.fmpq_poly, point: int) -> flint.fmpq_poly:
    """Return (s - c)^d f(1/(s - c)), monic."""
    reversed_ = flint.fmpq_poly(factor.coeffs()[::-1])(flint.fmpq_poly([-point, 1]))
    return reversed_ / reversed_.leading_coefficient()


SIZES = "(s E - A) M = 0, W M = I, the same of the transposed pencil, and the blocks add up"


@dataclass(frozen=True)
class KroneckerForm(ExactValue):
    r"""The invariants of a pencil sE - A under changes of both bases.

    Attributes
    ----------
    pencil : PolynomialMatrix
        sE - A, p x m.
    right_indices, left_indices : tuple of int
        Degrees of minimal bases of both null spaces: blocks :math:`L_\epsilon` of :math:`\epsilon
        \times (\epsilon + 1)` and :math:`L_\eta'`.
    invariant_polynomials : tuple of sympy.Poly
        Of the finite part, of degree 1 or more, each a divisor of the next.
    infinite_orders : tuple of int
        Sizes of the nilpotent blocks N_k at infinity, 1 or more.
    right_basis, left_basis : MinimalBasis
        With their certificates; the left one of the transposed pencil.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    """

    pencil: PolynomialMatrix
    right_indices: tuple[int, ...]
    left_indices: tuple[int, ...]
    invariant_polynomials: tuple[Poly, ...]
    infinite_orders: tuple[int, ...]
    right_basis: MinimalBasis
    left_basis: MinimalBasis
    exceptional: tuple[Expr, ...]

    @property
    def is_regular(self) -> bool:
        """Whether the pencil is square with det(sE - A) not zero for all s."""
        return not self.right_indices and not self.left_indices

    @property
    def finite_polynomial(self) -> Poly:
        """The product of the invariant polynomials; 1 if there are none."""
        one = Poly(1, self.pencil.variable, domain=sympy.QQ)
        return canonical(sympy.prod(self.invariant_polynomials, start=one))

    @property
    def certificate(self) -> Certificate:
        """Both null spaces with their left inverses, and the sizes of all blocks added up."""
        finite = sum(int(p.degree()) for p in self.invariant_polynomials)
        regular = finite + sum(self.infinite_orders)
        right, left = self.right_indices, self.left_indices
        rows = regular + sum(right) + sum(left) + len(left)
        columns = regular + sum(right) + len(right) + sum(left)
        row_count, column_count = self.pencil.shape
        parts = [self.right_basis.certificate.residual, self.left_basis.certificate.residual]
        return certificate_of(
            SIZES, [*parts, [Integer(rows - row_count), Integer(columns - column_count)]], "form"
        )

    def __str__(self) -> str:
        finite = ", ".join(map(format_polynomial, self.invariant_polynomials)) or "none"
        return (
            f"right indices {self.right_indices}, left indices {self.left_indices}, finite "
            f"{finite}, infinite {self.infinite_orders}"
        )

    def _repr_latex_(self) -> str:
        s = self.pencil.variable
        blocks = [f"L_{{{index}}}" for index in self.right_indices]
        blocks += [f"L_{{{index}}}^T" for index in self.left_indices]
        blocks += [rf"{s} I - C_{{{latex(p)}}}" for p in self.invariant_polynomials]
        blocks += [rf"{s} N_{{{order}}} - I" for order in self.infinite_orders]
        form = diagonal(blocks) if blocks else "0"
        return displayed(rf"{latex(self.pencil)} \sim {form}", unless(self.exceptional))


@carrying()
def kronecker_form(
    A: MatrixLike, E: MatrixLike, *, variable: str | Symbol | None = None
) -> KroneckerForm:
    r"""Find Kronecker's invariants of a pencil.

    .. math:: sE - A \;\sim\; \mathrm{diag}(L_{\epsilon_1}, \ldots,\; L_{\eta_1}', \ldots,\;
              sI - J,\; sN - I)

    Parameters
    ----------
    A, E : matrix
        p x m each, of any shape; with symbols, for generic values of them.
    variable : str or Symbol, optional
        Of the polynomials; default: s, or lambda where the matrices have a symbol s.

    Raises
    ------
    InputError, BudgetError
        If the shapes differ or are empty, or the matrices are too large.

    Notes
    -----
    The finite part is that of the Smith form of sE - A, the infinite one the powers of s in that of
    E - sA: for a regular pencil the form of Weierstrass. The sizes add up to the rank. With symbols
    both Smith forms are computed; where all numbers are rational, what is left between the
    subspaces of both minimal bases is one square matrix, and they are its elementary divisors.
    Source: L. Kronecker (1890); F. R. Gantmacher, The Theory of Matrices, vol. 2, XII; P. Van
    Dooren, Linear Algebra and its Applications 27 (1979).

    Examples
    --------
    >>> from compensator_theory.forms import kronecker_form
    >>> print(kronecker_form([[0, 1, 0], [0, 0, 2]], [[1, 0, 0], [0, 0, 1]]))
    right indices (1,), left indices (), finite s - 2, infinite ()
    >>> print(kronecker_form([[1, 0], [0, 1]], [[0, 1], [0, 0]]))
    right indices (), left indices (), finite none, infinite (2,)
    """
    a, e = exact_matrix(A, "A"), exact_matrix(E, "E")
    s = variable_for_matrix(variable, a, e)
    if a.shape != e.shape or 0 in a.shape:
        raise InputError(
            f"A is {a.rows} x {a.cols} and E is {e.rows} x {e.cols}; both need one shape, with at "
            "least one row and one column"
        )
    if is_rational_matrix(a) and is_rational_matrix(e):
        return _rational(to_flint(a), to_flint(e), s)
    pencil, reverse = _pencil(-a, e, s), _pencil(e, -a, s)
    right, left = minimal_basis(pencil), minimal_basis(pencil.T)
    finite, infinite = smith_form(pencil), smith_form(reverse)
    orders = []
    for invariant in infinite.invariant_polynomials:
        order = 0
        while invariant.coeff_monomial(s**order) == 0:
            order += 1
        orders.append(order)
    lowest = [
        p.coeff_monomial(s**k) for p, k in zip(infinite.invariant_polynomials, orders, strict=True)
    ]
    parts = (right, left, finite, infinite)
    return KroneckerForm(
        pencil,
        right.indices,
        left.indices,
        tuple(p for p in finite.invariant_polynomials if p.degree()),
        tuple(k for k in orders if k),
        right,
        left,
        exceptional_factors(
            [*(x for part in parts for x in part.exceptional), *map(sympy.sympify, lowest)]
        ),
    )


def _pencil(constant: ImmutableMatrix, slope: ImmutableMatrix, s: Symbol) -> PolynomialMatrix:
    """Return s times the slope plus the constant."""
    if (read := over_common_symbols(slope, constant)) is None:
        return polynomial_matrix(s * slope + constant, s)
    work, (first, second) = read
    rows = (
        tuple(
            work.polynomial([(x, first.below)] * (not x.is_zero()) + [(y, second.below)], s)
            for x, y in zip(*row, strict=True)
        )
        for row in zip(first.grid(), second.grid(), strict=True)
    )
    return PolynomialMatrix(tuple(rows))


def _rational(A: flint.fmpq_mat, E: flint.fmpq_mat, s: Symbol) -> KroneckerForm:
    """Find the form without a Smith form, whose numbers grow too long."""
    ask("degree", max(A.nrows(), A.ncols()), "the pencil")
    rows = [
        [from_flint_polynomial(flint.fmpq_poly([-a, e]), s) for a, e in zip(*row, strict=True)]
        for row in zip(A.tolist(), E.tolist(), strict=True)
    ]
    pencil = PolynomialMatrix(tuple(map(tuple, rows)))
    common = lcm(int(A.numer_denom()[1]), int(E.numer_denom()[1]))
    work = Pencil((A * common).numer_denom()[0], (E * common).numer_denom()[0])
    right, left = work.null_vectors(), work.T.null_vectors()
    finite, infinite = elementary_divisors(work, right, left)
    return KroneckerForm(
        pencil,
        tuple(len(vector) - 1 for vector in right),
        tuple(len(vector) - 1 for vector in left),
        tuple(from_flint_polynomial(p, s) for p in invariant_polynomials(finite)),
        tuple(sorted(infinite)),
        basis_of_pencil(pencil, right),
        basis_of_pencil(pencil.T, left),
        (),
    )
