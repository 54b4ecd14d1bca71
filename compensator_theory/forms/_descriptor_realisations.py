"""Realisations of improper transfer matrices, as descriptor systems."""

from __future__ import annotations

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory.forms._minimal_realisations import minimal_realisation
from compensator_theory.matrices._certificates import certificate_of
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import generic_answer_of
from compensator_theory.polynomials._poly import canonical, from_coefficients
from compensator_theory.systems._descriptor_systems import DescriptorSystem
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._transfer_matrices import TransferMatrix


@carrying()
def descriptor_realisation(
    G: TransferMatrixLike, variable: str | Symbol | None = None
) -> DescriptorSystem:
    r"""Realise any transfer matrix, proper or not, by a descriptor system without hidden modes.

    .. math:: G = C_1 (sI - J)^{-1} B_1 + D + C_2 (sN - I)^{-1} B_2, \qquad
              E = \mathrm{diag}(I, N), \quad A = \mathrm{diag}(J, I)

    Parameters
    ----------
    G : transfer matrix
        Anything :func:`transfer_matrix` reads; with symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Returns
    -------
    DescriptorSystem
        Its transfer matrix is compared with G. (J, B_1, C_1) is a minimal realisation of the
        strictly proper part; (N, B_2, C_2), with N nilpotent, one of the powers of s, so that
        every finite mode and every impulse is controllable and observable. D is the constant term.

    Raises
    ------
    InputError, BudgetError
        If it cannot be read, or is too large.

    Notes
    -----
    The polynomial part :math:`\sum_k P_k s^k` has the Markov parameters :math:`C_2 N^k B_2 = -P_k`
    for k >= 1 and 0 for k = 0. Source: L. Dai, Singular Control Systems (1989), 2-6.

    Examples
    --------
    >>> from compensator_theory import descriptor_realisation
    >>> pid = descriptor_realisation("2 + 1/s + 3*s")
    >>> print(pid, pid.index)
    E = [[1, 0, 0], [0, 0, 1], [0, 0, 0]]
    A = [[0, 0, 0], [0, 1, 0], [0, 0, 1]]
    B = [[1], [0], [-3]]
    C = [[1, 1, 0]]
    D = [[2]] 2
    """
    return _realised(G, variable)[0]


def _realised(
    G: TransferMatrixLike, variable: str | Symbol | None = None
) -> tuple[DescriptorSystem, tuple[Expr, ...]]:
    matrix = transfer_matrix(G, variable)
    s, (p, m) = matrix.variable, matrix.shape
    divided = [[entry.div(matrix.denominator) for entry in row] for row in matrix.numerators]
    whole = [[quotient for quotient, _ in row] for row in divided]
    left = tuple(tuple(canonical(remainder) for _, remainder in row) for row in divided)
    degree = max(0, *(int(q.degree()) for row in whole for q in row if not q.is_zero), 0)
    ask("entries", (degree + 1) ** 2 * p * m, "the Hankel matrix of the powers")
    slow = minimal_realisation(TransferMatrix(left, matrix.denominator))
    parts, exceptional = [slow.realisation], slow.exceptional
    if degree:
        z = sympy.Symbol("z")
        powers = tuple(
            tuple(from_coefficients([0, *_coefficients(-q, degree)], z) for q in row)
            for row in whole
        )
        fast = minimal_realisation(TransferMatrix(powers, canonical(Poly(z ** (degree + 1), z))))
        parts, exceptional = [*parts, fast.realisation], exceptional + fast.exceptional
    one = [identity_matrix(part.n) for part in parts]
    system = DescriptorSystem(
        sympy.diag(one[0], *(part.A for part in parts[1:])),
        sympy.diag(parts[0].A, *one[1:]),
        ImmutableMatrix.vstack(*(part.B for part in parts)),
        ImmutableMatrix.hstack(*(part.C for part in parts)),
        ImmutableMatrix(p, m, lambda i, j: whole[i][j].coeff_monomial(1)),
        s,
        matrix.sample_time,
    )
    residual = system.transfer_matrix() - matrix
    entries = [entry.as_expr() for row in residual.numerators for entry in row]
    certificate_of("C (sE - A)^-1 B + D = G", [entries], "descriptor realisation")
    return system, exceptional


def _coefficients(poly: Poly, degree: int) -> list[Expr]:
    """Return the coefficients of the powers 1 to degree."""
    return [poly.coeff_monomial(poly.gen**k) for k in range(1, degree + 1)]


generic_answer_of(descriptor_realisation)(_realised)
