"""Exact realisations and the transfer matrices they realise."""

from __future__ import annotations

from math import comb, prod
from typing import TypeAlias

import flint
import sympy
from sympy import ImmutableMatrix, Matrix, Poly, Rational, Symbol

from compensator_theory.matrices._certificates import Certificate, proven
from compensator_theory.matrices._domain_matrices import domain_matrices
from compensator_theory.matrices._flint_matrices import (
    from_flint,
    is_rational_matrix,
    of_rows,
    rational_in_flint,
    symbols_in,
    zero_matrix,
)
from compensator_theory.matrices._flint_polynomials import from_flint_polynomial
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    in_lowest_terms,
    multiplied,
)
from compensator_theory.matrices._symbolic_matrices import SymbolicMatrix, symbolic_matrix
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._poly import canonical, from_coefficients, scaled
from compensator_theory.systems._transfer_functions import (
    TransferFunction,
    require_proper,
)
from compensator_theory.systems._transfer_matrices import TransferMatrix

IDENTITY = "adj({0}I - A) B by ({0}I - A) adj({0}I - A) B = det({0}I - A) B"


def transfer_matrix_of_realisation(
    A: Matrix,
    B: Matrix,
    C: Matrix,
    D: Matrix,
    variable: Symbol,
    sample_time: Rational | None = None,
) -> TransferMatrix:
    r"""Return the transfer matrix over the unreduced characteristic polynomial.

    .. math:: G = \frac{C\,\mathrm{adj}(qI - A)\,B + D\det(qI - A)}{\det(qI - A)}

    Notes
    -----
    The adjugate is never formed: with :math:`\det(qI-A) = \sum_k c_k q^k` the coefficients of
    :math:`\mathrm{adj}(qI-A)B` are :math:`V_1 = B`, :math:`V_{j+1} = A V_j + c_{n-j} B`
    (Faddeev and LeVerrier), and :math:`V_{n+1} = 0` proves
    :math:`(qI - A)\,\mathrm{adj}(qI-A)B = \det(qI-A)B` for all q. That is the certificate of the
    result. Source: (2.6), (2.7).
    """
    fraction = (
        _in_flint(A, B, C, D, variable)
        or _with_symbols(A, B, C, D, variable)
        or _in_sympy(A, B, C, D, variable)
    )
    entries, denominator, residual = fraction
    certificate = proven(Certificate(IDENTITY.format(variable.name), residual), "conversion")
    return TransferMatrix._of_canonical(
        numerators=entries,
        denominator=denominator,
        certificate=certificate,
        sample_time=sample_time,
    )


Verified: TypeAlias = tuple[tuple[tuple[Poly, ...], ...], Poly, ImmutableMatrix]
"""Numerators, denominator, and the residual of the identity."""


def _in_flint(A: Matrix, B: Matrix, C: Matrix, D: Matrix, variable: Symbol) -> Verified | None:
    """Rational matrices: SymPy's form is written only at the end."""
    a, b, c, d = map(rational_in_flint, (A, B, C, D))
    if a is None or b is None or c is None or d is None or not A.rows:
        return None
    (whole, below), (into, below_b), (out, below_c) = (m.numer_denom() for m in (a, b, c))
    n, characteristic = A.rows, whole.charpoly()  # of below A, so that all numbers are integers
    v, responses = into, []
    for power in range(1, n + 1):
        responses.append((out * v).entries())
        v = whole * v + into * characteristic[n - power]
    denominator = _spread(characteristic.coeffs(), below, n)
    scale = flint.fmpq(1, below_b * below_c * below ** (n - 1))
    rows = tuple(
        tuple(
            from_flint_polynomial(
                _spread([m[k] for m in reversed(responses)], below, 0) * scale
                + (denominator * direct if (direct := d[i, j]) else 0),
                variable,
            )
            for j, k in enumerate(range(i * D.cols, (i + 1) * D.cols))
        )
        for i in range(D.rows)
    )
    return rows, from_flint_polynomial(denominator, variable), from_flint(flint.fmpq_mat(v))


def _spread(ascending: list[flint.fmpz], below: flint.fmpz, power: int) -> flint.fmpq_poly:
    """Return the polynomial in s of one in s times `below`, over a power of `below`."""
    if below != 1:
        ascending = [c * below**k for k, c in enumerate(ascending)]
    return flint.fmpq_poly(ascending) / below**power


def _with_symbols(A: Matrix, B: Matrix, C: Matrix, D: Matrix, variable: Symbol) -> Verified | None:
    """Rational functions of symbols: each step is kept in lowest terms by python-flint."""
    if not (A.rows and B.cols and C.rows) or variable in set().union(
        *(symbols_in(matrix) for matrix in (A, B, C, D))
    ):
        return None
    a, b, c, d = map(symbolic_matrix, (A, B, C, D))
    if a is None or b is None or c is None or d is None:
        return None
    require_few_terms(a)
    denominator = characteristic_polynomial(a, variable)
    descending = denominator.all_coeffs()
    coefficients, v = [d], b
    for coefficient in descending[1:]:
        coefficients.append(multiplied(c, v) + d * coefficient)
        v = multiplied(a, v) + b * coefficient
    rows = _polynomials(coefficients, D, variable)
    return rows, denominator, v


def _polynomials(
    coefficients: list[ImmutableMatrix], D: Matrix, variable: Symbol
) -> tuple[tuple[Poly, ...], ...]:
    """Return the polynomial matrix with these coefficients, of the shape of D."""
    return tuple(
        tuple(
            from_coefficients([matrix[row, column] for matrix in coefficients], variable)
            for column in range(D.cols)
        )
        for row in range(D.rows)
    )


def require_few_terms(A: ImmutableMatrix, matrices: int = 1) -> None:
    """Ask for the terms of adj(sI - A) over the powers of a denominator with symbols.

    `matrices` says of how many transfer matrices and products.
    """
    if not isinstance(A, SymbolicMatrix) or A.flint_form.below.is_constant():
        return
    polynomials = [A.flint_form.below, *(x for x in A.flint_form.flat if not x.is_zero())]
    symbols, n = len(A.work.symbols), A.rows
    degree = n * max(int(x.total_degree()) for x in polynomials)
    separate = [max(degrees) for degrees in zip(*(x.degrees() for x in polynomials), strict=True)]
    longest = max(map(len, polynomials))  # whose n-th power has no more terms than a sum's
    dense = min(comb(degree + symbols, symbols), prod(n * int(d) + 1 for d in separate))
    terms = min(dense, comb(longest + n - 1, n))
    ask(
        "entries",
        matrices * n**3 * terms,
        "a transfer matrix with denominators of symbols, term by term,",
    )


def _in_sympy(A: Matrix, B: Matrix, C: Matrix, D: Matrix, variable: Symbol) -> Verified:
    denominator = characteristic_polynomial(A, variable)
    descending = denominator.all_coeffs()
    coefficients = [D * c for c in descending]
    a, b, c, scalars = domain_matrices(A, B, C, ImmutableMatrix([descending]))
    v = b
    for power in range(1, A.rows + 1):
        coefficients[power] += (c * v).to_Matrix()
        v = a * v + b * scalars[0, power].element
    residual = ImmutableMatrix(v.to_Matrix()) if A.rows else zero_matrix(0, B.cols)
    rows = _polynomials(coefficients, D, variable)
    return rows, denominator, residual


def fed_back_polynomial(A: Matrix, B: Matrix, K: Matrix, variable: Symbol) -> Poly:
    r"""Return :math:`\det(sI - A - BK)`, of one input by a change of rank 1.

    .. math:: \det(sI - A - BK) = \det(sI - A) - K\,\mathrm{adj}(sI - A)\,B

    The numbers of A + BK are as long as those of K, and their powers longer.
    """
    if B.cols == 1 and all(map(is_rational_matrix, (A, B, K))):
        open_loop = transfer_matrix_of_realisation(A, B, K, zero_matrix(1, 1), variable)
        return canonical(open_loop.denominator - open_loop.numerators[0][0])
    return characteristic_polynomial(in_lowest_terms(A + multiplied(B, K)), variable)


def controllable_canonical_form(
    G: TransferFunction,
) -> tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]:
    r"""Realise a proper transfer function, common factors included.

    .. math:: A = \begin{bmatrix} 0 & I \\ -D_0 & \cdots\ -D_{n-1} \end{bmatrix}, \quad
              B = \begin{bmatrix} 0 \\ 1 \end{bmatrix}

    Parameters
    ----------
    G : TransferFunction
        Proper, of order n.

    Returns
    -------
    tuple of sympy.ImmutableMatrix
        (A, B, C, D) with :math:`G = C(qI - A)^{-1}B + D` and :math:`\det(qI - A) = D(q)`.

    Notes
    -----
    Source: (7.26).

    Examples
    --------
    >>> from compensator_theory import transfer_function
    >>> from compensator_theory.systems._state_space import controllable_canonical_form
    >>> controllable_canonical_form(transfer_function("(s + 3)/(s**2 + 2*s)"))[0]
    Matrix([
    [0,  1],
    [0, -2]])
    """
    require_proper(G, "plant")
    n = G.order
    bottom = G.denominator.all_coeffs()
    top = G.numerator.all_coeffs()
    direct = top[0] if len(top) > n else sympy.Integer(0)
    if direct != 0:
        top = canonical(G.numerator - scaled(G.denominator, direct)).all_coeffs()
    shift = [[int(column == row + 1) for column in range(n)] for row in range(n - 1)]
    last = [-c for c in reversed(bottom[1:])]
    return (
        of_rows([*shift, last] if n else [], (n, n)),
        of_rows([[int(row == n - 1)] for row in range(n)], (n, 1)),
        of_rows([[*reversed(top), *[0] * (n - len(top))][:n]], (1, n)),
        of_rows([[direct]], (1, 1)),
    )
