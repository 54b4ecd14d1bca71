"""The regular part of a rational pencil, and its elementary divisors."""

from collections.abc import Sequence
from typing import TypeAlias

import flint

from compensator_theory.canonical_forms.pencil_kernels import NullVectors, Pencil
from compensator_theory.errors import NoSolutionError
from compensator_theory.matrices.residues import pivots
from compensator_theory.polynomials.budget import ask, decimal_digits

Orders: TypeAlias = list[tuple[flint.fmpq_poly, list[int]]]
"""Irreducible polynomials with their exponents in the elementary divisors, the largest first."""


def elementary_divisors(
    pencil: Pencil, right: NullVectors, left: NullVectors
) -> tuple[Orders, list[int]]:
    r"""Return the finite elementary divisors of a pencil, and the orders of its infinite ones.

    The coefficients of a minimal basis span a subspace that sE - A maps into one with a dimension
    less for each vector; what is left over between both sides is the regular part, and with t =
    1/(s - c) it is t I - F for one matrix F, which has infinity at t = 0.

    Parameters
    ----------
    pencil : Pencil
    right, left : vectors
        Minimal bases of both null spaces.

    Raises
    ------
    NoSolutionError
        If the sizes do not add up to the rank: then a basis was none.

    Examples
    --------
    >>> from flint import fmpz_mat
    >>> from compensator_theory.canonical_forms.pencil_kernels import Pencil
    >>> from compensator_theory.canonical_forms.regular_parts import elementary_divisors
    >>> pencil = Pencil(fmpz_mat([[2, 0], [0, 1]]), fmpz_mat([[1, 0], [0, 0]]))
    >>> elementary_divisors(pencil, [], [])
    ([(x + (-2), [1])], [1])
    """
    size = pencil.rank - _degrees(right) - _degrees(left)
    columns = _between(pencil.E, right, left)
    rows = _between(pencil.E.transpose(), left, right)
    regular = [rows.transpose() * part * columns for part in (pencil.R, pencil.E)]
    left_over = [
        x
        for part in (pencil.R, pencil.E)
        for a, b, given in ((rows, right, part), (columns, left, part.transpose()))
        if b
        for x in (a.transpose() * given * _columns(b)).entries()
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
    """Return the products of elementary divisors that divide each other, the smallest first.

    Examples
    --------
    >>> from flint import fmpq_poly
    >>> from compensator_theory.canonical_forms.regular_parts import invariant_polynomials
    >>> invariant_polynomials([(fmpq_poly([0, 1]), [2, 1]), (fmpq_poly([1, 1]), [1])])
    [x, x^3 + x^2]
    """
    one = flint.fmpq_poly([1])
    found = [one] * max((len(exponents) for _, exponents in orders), default=0)
    for factor, exponents in orders:
        for k, exponent in enumerate(exponents):
            found[k] *= factor**exponent
    return found[::-1]


def _degrees(vectors: NullVectors) -> int:
    return sum(len(vector) - 1 for vector in vectors)


def _digits(regular: Sequence[flint.fmpz_mat]) -> int:
    """Bound the digits of a minor by Hadamard's inequality."""
    rows = zip(*(matrix.tolist() for matrix in regular), strict=True)
    squares = (sum(int(x) ** 2 for part in row for x in part) for row in rows)
    return sum(decimal_digits(square.bit_length()) for square in squares) // 2


def _columns(vectors: NullVectors) -> flint.fmpz_mat:
    """Return all coefficients side by side."""
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
    own = [list(column) for vector in right for column in vector]
    both = pivots(flint.fmpz_mat([*own, *space]).transpose())
    chosen = [space[k - len(own)] for k in both if k >= len(own)]
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
