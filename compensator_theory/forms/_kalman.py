"""Kalman's decomposition of the state space into controllable and observable parts."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._echelon import echelon, independent_columns
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import identity_matrix, zero_matrix
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, in_lowest_terms
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._controllability import controllability_matrix
from compensator_theory.systems._realisations import Realisation

IDENTITY = "A T = T A', B = T B', C T = C', and the blocks of A', B', C' that must be zero"


@dataclass(frozen=True)
class KalmanDecomposition(ExactValue):
    r"""A realisation in a basis that splits controllable from observable states.

    .. math:: A' = \begin{bmatrix} A_{11} & A_{12} & A_{13} & A_{14} \\ 0 & A_{22} & 0 & A_{24} \\
              0 & 0 & A_{33} & A_{34} \\ 0 & 0 & 0 & A_{44} \end{bmatrix}, \quad
              B' = \begin{bmatrix} B_1 \\ B_2 \\ 0 \\ 0 \end{bmatrix}, \quad
              C' = \begin{bmatrix} 0 & C_2 & 0 & C_4 \end{bmatrix}

    Attributes
    ----------
    realisation : Realisation
        (A', B', C', D).
    T : sympy.ImmutableMatrix
        The basis, x = T x'.
    dimensions : tuple of int
        Numbers of states that are controllable and unobservable, controllable and observable,
        neither, observable and uncontrollable, in this order.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the decomposition holds where none of them is zero,
        and where one is, the dimensions may differ. Empty without symbols.
    certificate : Certificate
        The change of basis and the blocks that are zero.
    """

    realisation: Realisation
    T: ImmutableMatrix
    dimensions: tuple[int, int, int, int]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def minimal(self) -> Realisation:
        """The controllable and observable part (A_22, B_2, C_2, D): the same transfer matrix."""
        whole, part = self.realisation, self._block(1)
        return Realisation(
            whole.A[part, part],
            whole.B[part, :],
            whole.C[:, part],
            whole.D,
            whole.variable,
            feedback=whole.feedback,
            sample_time=whole.sample_time,
        )

    @property
    def is_minimal(self) -> bool | None:
        """Whether every state is controllable and observable; None if that depends on symbols."""
        hidden = self.dimensions[1] < self.realisation.n
        return False if hidden else None if self.exceptional else True

    @property
    def block_polynomials(self) -> tuple[Poly, Poly, Poly, Poly]:
        """Characteristic polynomials of the four diagonal blocks, in the order of `dimensions`."""
        a, b, c, d = (self._polynomial(block) for block in range(4))
        return a, b, c, d

    @property
    def input_decoupling(self) -> Poly:
        """Polynomial of the modes that the input does not reach."""
        return canonical(self._polynomial(2) * self._polynomial(3))

    @property
    def output_decoupling(self) -> Poly:
        """Polynomial of the modes that the output does not show."""
        return canonical(self._polynomial(0) * self._polynomial(2))

    def _block(self, index: int) -> slice:
        start = sum(self.dimensions[:index])
        return slice(start, start + self.dimensions[index])

    def _polynomial(self, index: int) -> Poly:
        part = self._block(index)
        return characteristic_polynomial(self.realisation.A[part, part], self.realisation.variable)

    def __str__(self) -> str:
        names = ("c and not o", "c and o", "neither", "o and not c")
        sizes = ", ".join(f"{n}: {d}" for n, d in zip(names, self.dimensions, strict=True))
        return f"{sizes}\n{self.realisation}"

    def _repr_latex_(self) -> str:
        return displayed(
            f"x = T x', \\quad T = {latex(self.T)}",
            rf"\begin{{bmatrix}} A' & B' \\ C' & D' \end{{bmatrix}} = {latex(self.realisation)}",
            rf"n = {' + '.join(map(str, self.dimensions))}",
            unless(self.exceptional),
        )


@carrying()
def kalman_decomposition(
    plant: RealisationLike, variable: str | Symbol | None = None
) -> KalmanDecomposition:
    r"""Split the states of a realisation by controllability and observability.

    .. math:: \mathcal R = \mathrm{im}\,[B\ AB \cdots A^{n-1}B], \qquad
              \mathcal N = \ker\,[C;\ CA;\ \cdots;\ CA^{n-1}]

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or input of :func:`realisation`
        With symbols, for generic values of them; see `exceptional`.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Returns
    -------
    KalmanDecomposition
        The basis is that of R and N, then of R, of N and of everything, each extended by first
        independent columns; complements are not unique, so T is one of many.

    Raises
    ------
    InputError, ImproperError, BudgetError
        If the plant cannot be read, is improper, or too large.

    Notes
    -----
    Source: R. E. Kalman, Mathematical description of linear dynamical systems, SIAM J. Control 1
    (1963).

    Examples
    --------
    >>> from compensator_theory import kalman_decomposition
    >>> decomposition = kalman_decomposition(([[-1, 0], [0, -2]], [[1], [0]], [[1, 1]]), "s")
    >>> decomposition.dimensions, decomposition.input_decoupling
    ((0, 1, 0, 1), Poly(s + 2, s, domain='QQ'))
    >>> kalman_decomposition(([["a", 0], [0, "b"]], [[1], ["c"]], [[1, 1]]), "s").exceptional
    (c, a - b)
    """
    source = realisation(plant, variable)
    n, inputs, outputs = source.n, source.B.cols, source.C.rows
    ask("entries", n * n * max(inputs, outputs, 1), "the controllability or observability matrix")
    reached, minor = independent_columns(_krylov(source.A, source.B))
    observability = echelon(_krylov(source.A.T, source.C.T).T)
    hidden = observability.kernel()
    divisors = [minor, observability.divided_by]
    meeting = echelon(reached.row_join(-hidden))
    divisors.append(meeting.divided_by)
    blocks = [ImmutableMatrix(reached * meeting.kernel()[: reached.cols, :])]
    for space in (reached, hidden, identity_matrix(n)):
        known = ImmutableMatrix.hstack(zero_matrix(n, 0), *blocks)
        if len(blocks) == 2:  # unobservable states join the first block, not the second
            basis, minor = independent_columns(blocks[0].row_join(space))
            blocks.append(basis[:, blocks[0].cols :])
        else:
            basis, minor = independent_columns(known.row_join(space))
            blocks.append(basis[:, known.cols :])
        divisors.append(minor)
    T = in_lowest_terms(ImmutableMatrix.hstack(*blocks))
    moved = source.in_basis(T) if n else source
    a, b, c, d = (int(block.cols) for block in blocks)
    certificate = _certificate(source, moved, T, (a, b, c, d))
    return KalmanDecomposition(moved, T, (a, b, c, d), exceptional_factors(divisors), certificate)


def _krylov(A: ImmutableMatrix, B: ImmutableMatrix) -> ImmutableMatrix:
    """Return the controllability matrix, 0 x m where there are no states."""
    return controllability_matrix(A, B) if A.rows else zero_matrix(0, B.cols)


def _certificate(
    source: Realisation, moved: Realisation, T: ImmutableMatrix, sizes: tuple[int, int, int, int]
) -> Certificate:
    parts = [index for index, size in enumerate(sizes) for _ in range(size)]
    must_vanish = {(1, 0), (1, 2), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2)}
    left = [
        *(source.A * T - T * moved.A),
        *(source.B - T * moved.B),
        *(source.C * T - moved.C),
        *(
            moved.A[i, j]
            for i, row in enumerate(parts)
            for j, column in enumerate(parts)
            if (row, column) in must_vanish
        ),
        *(entry for i, row in enumerate(parts) if row > 1 for entry in moved.B[i, :]),
        *(entry for j, column in enumerate(parts) if column in (0, 2) for entry in moved.C[:, j]),
    ]
    return certificate_of(IDENTITY, [left], "decomposition")
