"""The linear equations behind the placement of poles with several signals."""

import sympy
from sympy import Expr, ImmutableMatrix, Poly

from compensator_theory.canonical_forms.row_forms import row_reduced_form
from compensator_theory.matrices.linear_algebra import solve
from compensator_theory.polynomial_matrices.polynomial_matrices import PolynomialMatrix
from compensator_theory.polynomials.poly import canonical, from_coefficients
from compensator_theory.structure.coprime_fractions import coprime_fractions
from compensator_theory.transfer_functions.transfer_matrices import TransferMatrix


def reduced_left_fraction(
    G: TransferMatrix,
) -> tuple[PolynomialMatrix, PolynomialMatrix, ImmutableMatrix, list[int]]:
    """Return D_l and N_l with ascending row degrees, the inverse leading matrix, the degrees.

    Examples
    --------
    >>> from compensator_theory import transfer_matrix
    >>> from compensator_theory.placement.matrix_equations import reduced_left_fraction
    >>> reduced_left_fraction(transfer_matrix([["1/s", 0], [0, "1/s**2"]]))[3]
    [1, 2]
    """
    fractions = coprime_fractions(G)
    reduced = row_reduced_form(fractions.D_l)
    order = sorted(range(G.shape[0]), key=lambda i: reduced.row_degrees[i])
    N = reduced.U @ fractions.N_l
    D_l = PolynomialMatrix(tuple(reduced.form.rows[i] for i in order))
    N_l = PolynomialMatrix(tuple(N.rows[i] for i in order))
    leading = reduced.leading_matrix.extract(order, list(range(G.shape[0])))
    H = solve(ImmutableMatrix(leading), sympy.eye(G.shape[0]))
    return D_l, N_l, H, [reduced.row_degrees[i] for i in order]


def coefficient_columns(
    D: PolynomialMatrix, N: PolynomialMatrix, free: int, order: int, heights: list[int]
) -> list[list[Expr]]:
    """Return the columns that D s^k, k < free, and N s^k, k <= order, add to the equations.

    Examples
    --------
    >>> from compensator_theory import polynomial_matrix
    >>> from compensator_theory.placement.matrix_equations import coefficient_columns
    >>> D, N = polynomial_matrix([["s + 2"]]), polynomial_matrix([[3]], "s")
    >>> coefficient_columns(D, N, 1, 1, [2])
    [[2, 1], [3, 0], [0, 3]]
    """
    s, columns = D.variable, []
    for matrix, count in ((D, free), (N, order + 1)):
        for entry in range(matrix.shape[1]):
            for k in range(count):
                columns.append([
                    matrix[i, entry].coeff_monomial(s ** (power - k)) if power >= k else 0
                    for i, height in enumerate(heights)
                    for power in range(height)
                ])  # fmt: skip
    return columns


def pair_of_columns(
    vector: ImmutableMatrix, shape: tuple[int, int], free: int, order: int, model: Poly
) -> tuple[list[Poly], list[Poly]]:
    """Return the columns (D_c without its leading term, N_c) of one solution.

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.placement.matrix_equations import pair_of_columns
    >>> found = pair_of_columns(ImmutableMatrix([5, 6, 7]), (1, 1), 1, 1, polynomial("s"))
    >>> [poly.as_expr() for column in found for poly in column]
    [5*s, 7*s + 6]
    """
    p, m = shape
    entries, s = list(vector), model.gen
    below, top = entries[: p * free], entries[p * free :]
    parts = [below[i * free : (i + 1) * free][::-1] or [sympy.S.Zero] for i in range(p)]
    D = [canonical(from_coefficients(part, s) * model) for part in parts]
    width = order + 1
    N = [from_coefficients(top[i * width : (i + 1) * width][::-1], s) for i in range(m)]
    return D, N


def in_column(entries: list[Poly], column: int, width: int) -> PolynomialMatrix:
    """Return a matrix that is zero but for one column.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.placement.matrix_equations import in_column
    >>> print(in_column([polynomial("s")], 1, 2))
    [[0, s]]
    """
    zero = Poly(0, entries[0].gen, domain=sympy.QQ)
    return PolynomialMatrix(
        tuple(tuple(e if j == column else zero for j in range(width)) for e in entries)
    )


def multiple(matrix: PolynomialMatrix, factor: Poly) -> PolynomialMatrix:
    """Multiply every entry by a polynomial.

    Examples
    --------
    >>> from compensator_theory import polynomial, polynomial_matrix
    >>> from compensator_theory.placement.matrix_equations import multiple
    >>> print(multiple(polynomial_matrix([["s", 1]]), polynomial("s + a", "s")))
    [[s**2 + a*s, s + a]]
    """
    return PolynomialMatrix(tuple(tuple(canonical(e * factor) for e in r) for r in matrix.rows))
