"""Target models that keep transmission zeros with their directions, exactly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import ClassVar

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.loops._directions import (
    gaussian,
    rational_matrix,
    read_direction,
    residual,
)
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.matrices._linear_algebra import rank, solve
from compensator_theory.polynomials._budget import ask, integer, is_integer, listed, repr_of
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._letters import names_in_all
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._transfer_matrices import TransferMatrix

IDENTITY = "eta' W G_f(z0) = 0 at every zero"
# A zero on the unit circle may have been rounded.
CIRCLE = sympy.Rational(1, 10**12)
q = Symbol("q")

Direction = tuple[NumberLike, Sequence[NumberLike]]


@dataclass(frozen=True)
class ZeroDirectionTarget(ExactValue):
    """An FIR target model with prescribed zeros and left zero directions.

    Attributes
    ----------
    transfer_matrix : TransferMatrix
        G_f, with a power of q as its denominator.
    H : sympy.ImmutableMatrix
        The requested leading coefficients, l_z x l_u.
    delays : tuple of int
        Relative degree of every row.
    zeros : tuple of pairs (z0, eta)
        As requested, exact; of a complex pair one.
    taps : int
        m, the coefficients behind the leading one.
    certificate : Certificate
        That G_f has every zero in its direction.
    """

    _REST: ClassVar[str] = ".zeros lists them"
    transfer_matrix: TransferMatrix
    H: ImmutableMatrix
    delays: tuple[int, ...]
    zeros: tuple[tuple[Expr, ImmutableMatrix], ...]
    taps: int
    certificate: Certificate

    def __str__(self) -> str:
        lines = [f"{text(zero)} in the direction {text(list(eta))}" for zero, eta in self.zeros]
        return "\n".join([f"G_f = {self.transfer_matrix}", *lines])

    def _repr_latex_(self) -> str:
        at = [
            rf"\eta^T G_f\left({latex(zero)}\right) = 0, \; \eta = {latex(eta)}"
            for zero, eta in self.zeros
        ]
        return displayed(f"G_f = {latex(self.transfer_matrix)}", *at)


@refusing
def zero_direction_target(
    H: Sequence[Sequence[NumberLike]],
    zeros: Sequence[Direction] = (),
    *,
    delays: int | Sequence[int] = 1,
    taps: int | None = None,
) -> ZeroDirectionTarget:
    r"""Build the FIR target model that has zeros in given output directions.

    .. math:: G_f = \mathrm{diag}(q^{-d_i})\,\Bigl(I + \sum_{k=1}^m L_k q^{-k}\Bigr) H,
              \qquad \eta_i' G_f(z_i) = 0

    with the least sum of squares of the entries of the :math:`L_k`. For one real zero, m = 1 and
    equal delays that is :math:`q^{-d}(I - z_0 q^{-1}\eta\eta'/\eta'\eta)H`.

    Parameters
    ----------
    H : l_z x l_u matrix of rationals
        Row i is the first coefficient of row i of G_zu that is not zero; of full rank. With more
        rows than columns the target is :math:`H(H'H)^{-1} L H'H q^{-d}`, since the controller
        sees z through H' z, and the directions are those of H' G_zu.
    zeros : sequence of pairs (z0, eta)
        On or outside the unit circle, with the left direction: :math:`\eta' G_{zu}(z_0) = 0`,
        without conjugation. A complex zero stands for itself and its conjugate. Rational, or with
        rational real and imaginary parts.
    delays : int or sequence of int
        Relative degree of G_zu, or of each of its rows.
    taps : int, optional
        m; the least that is enough by default: 1 where the directions are independent.

    Returns
    -------
    ZeroDirectionTarget

    Raises
    ------
    InputError
        If sizes do not fit, a number is not rational, H does not have full rank, or a zero is
        inside the unit circle.
    NoSolutionError
        If `taps` is too small, or the directions of one and the same zero are dependent.

    Notes
    -----
    The further zeros that m > 1 brings lie inside the unit circle: the least squares solution is
    a multichannel predictor (P. Whittle, Biometrika 50 (1963)). The condition is that of
    :math:`\tilde G_{zu} = q^{n_c}G_{zu}(D_c - N_c G_{yu})^{-1}`, which has every left zero
    direction of G_zu unless the inverse has a pole there: an internally unstable loop.

    ``rcac_numeric.targets.zero_direction_target`` makes a target model of it, of a plant too.

    Examples
    --------
    >>> from compensator_theory import zero_direction_target
    >>> target = zero_direction_target([[1, 0], [0, 2]], [("3/2", [1, -1])])
    >>> print(target.transfer_matrix)
    [[q - 3/4, 3/2], [3/4, 2*q - 3/2]]/(q**2)
    >>> target.certificate.holds
    True
    """
    leading = rational_matrix(H, "H")
    rows, columns = leading.shape
    if rank(leading) < min(rows, columns):
        raise InputError(
            f"H = {repr_of(leading.tolist(), 200)} does not have full rank, so that no target "
            "model with this leading coefficient has only the requested zeros; give the first "
            "coefficient that is not zero of every row, with the delays of the rows."
        )
    tall = rows > columns
    size = columns if tall else rows
    steps = _delays(delays, rows, tall)
    if not isinstance(zeros, Iterable):
        raise InputError(f"zeros = {repr_of(zeros)} must be a list of pairs (z0, eta)")
    known = tuple(_zero(pair, size) for pair in listed(zeros, "degree", "the list of zeros"))
    E, Z = _real_form(known, [0] * size if tall else list(steps), size)
    L = _least_squares(E, Z, size, taps)
    right = leading.T * leading if tall else leading
    left = leading * right.inv() if tall else Matrix.eye(rows)
    coefficients = [left * block * right for block in [Matrix.eye(size), *L]]
    G_f = _transfer_matrix(coefficients, steps)
    W = leading.T if tall else Matrix.eye(rows)
    left_over = [residual(G_f, zero, W, eta) for zero, eta in known]
    certificate = Certificate(
        IDENTITY, ImmutableMatrix(1, len(left_over) * columns, list(chain(*left_over)))
    )
    return ZeroDirectionTarget(G_f, ImmutableMatrix(leading), steps, known, len(L), certificate)


@refusing
def direction_residual(
    G_f: TransferMatrixLike,
    zero: NumberLike,
    eta: Sequence[NumberLike],
    *,
    variable: str | Symbol | None = None,
) -> ImmutableMatrix:
    r"""Return :math:`\eta' G_f(z_0)`: zero if and only if G_f has the zero in this direction.

    Parameters
    ----------
    G_f : transfer matrix
        Anything :func:`transfer_matrix` reads.
    zero, eta : numbers
        Exact; eta with as many entries as G_f has rows.
    variable : str or Symbol, optional
        Of G_f; default: evident.

    Raises
    ------
    InputError
        If eta is zero or has another length, z0 is a pole of G_f, or G_f has symbols.

    Examples
    --------
    >>> from compensator_theory.loops import direction_residual
    >>> G_f = [["(q - 3/2)/q**2", 0], [0, "1/q"]]
    >>> direction_residual(G_f, "3/2", [1, 0]), direction_residual(G_f, "3/2", [1, 1])
    (Matrix([[0, 0]]), Matrix([[0, 2/3]]))
    """
    G = transfer_matrix(G_f, variable)
    if names_in_all(G) - {G.variable.name}:
        raise InputError(
            f"{G} has symbols, but the residual needs numbers; substitute numbers for them"
        )
    z0, direction = gaussian(zero, f"the zero {repr_of(zero)}"), read_direction(eta, G.shape[0])
    return ImmutableMatrix(residual(G, z0, Matrix.eye(G.shape[0]), direction))


def _delays(delays: int | Sequence[int], rows: int, tall: bool) -> tuple[int, ...]:
    if isinstance(delays, Sequence):
        steps = tuple(listed(delays, "degree", "delays"))
    else:
        steps = (delays,) * rows
    if len(steps) != rows or not all(is_integer(d) and d >= 0 for d in steps):
        raise InputError(f"delays = {repr_of(delays)}: give one number of steps, or {rows} numbers")
    ask("degree", max(steps), "the target model with these delays")
    if tall and len(set(steps)) > 1:
        raise InputError("a target with more rows than columns needs one delay for all rows")
    return steps


def _zero(pair: Direction, size: int) -> tuple[Expr, ImmutableMatrix]:
    try:
        zero_like, eta = pair
    except (TypeError, ValueError):
        raise InputError(f"{repr_of(pair)} is not a pair (z0, eta)") from None
    z0 = gaussian(zero_like, f"the zero {repr_of(zero_like)}")
    a, b = z0.as_real_imag()
    if a**2 + b**2 < (1 - CIRCLE) ** 2:
        raise InputError(f"the zero {z0} is inside the unit circle; leave it out")
    direction = read_direction(eta, size)
    if b == 0 and any(entry.as_real_imag()[1] != 0 for entry in direction):
        raise InputError(f"the direction {list(direction)} of the real zero {z0} must be real")
    return z0, direction


def _real_form(
    zeros: Sequence[tuple[Expr, ImmutableMatrix]], delays: Sequence[int], size: int
) -> tuple[Matrix, Matrix]:
    """E with the real and imaginary parts of the directions as rows, and Z with E z = Z E."""
    E, blocks = Matrix(0, size, []), []
    for z0, eta in zeros:
        # The directions of the target without its delays.
        row = [
            sympy.expand(eta[i] * sympy.expand(z0 ** (max(delays) - d)))
            for i, d in enumerate(delays)
        ]
        parts = [entry.as_real_imag() for entry in row]
        a, b = z0.as_real_imag()
        E = E.col_join(Matrix([[real for real, _ in parts]]))
        if b != 0:
            E = E.col_join(Matrix([[imaginary for _, imaginary in parts]]))
        blocks.append(Matrix([[a]]) if b == 0 else Matrix([[a, -b], [b, a]]))
    return E, sympy.diag(*blocks) if blocks else Matrix(0, 0, [])


def _least_squares(E: Matrix, Z: Matrix, size: int, taps: int | None) -> list[Matrix]:
    """L_1, ..., L_m of least norm with E + sum of Z^{-k} E L_k = 0."""
    if taps is not None:
        integer(taps, "taps", at_least=0)
    ask("degree", taps or 0, "the target model with these taps")
    if not E.rows:
        return [Matrix.zeros(size, size)] * (taps or 0)
    inverse = Z.inv()
    columns, block = Matrix(E.rows, 0, []), E
    for m in range(1, (taps or E.rows) + 1):
        block = inverse * block
        columns = columns.row_join(block)
        if taps in (None, m) and rank(columns) == E.rows:
            whole = -columns.T * solve(columns * columns.T, E)
            return [whole[k * size : (k + 1) * size, :] for k in range(m)]
    if taps is not None and rank(columns) < E.rows:
        raise NoSolutionError(
            f"a target of {taps} taps cannot have {E.rows} zeros with these directions; leave the "
            "argument taps out"
        )
    raise NoSolutionError(
        "the directions of one zero are linearly dependent; a zero of multiplicity m needs m "
        "independent directions"
    )


def _transfer_matrix(coefficients: Sequence[Matrix], delays: Sequence[int]) -> TransferMatrix:
    order = len(coefficients) - 1 + max(delays)
    rows, columns = coefficients[0].shape

    def entry(i: int, j: int) -> Poly:
        terms = (c[i, j] * q ** (order - delays[i] - k) for k, c in enumerate(coefficients))
        return canonical(Poly(sum(terms, sympy.Integer(0)), q))

    numerators = tuple(tuple(entry(i, j) for j in range(columns)) for i in range(rows))
    return TransferMatrix(numerators, canonical(Poly(q**order, q)))
