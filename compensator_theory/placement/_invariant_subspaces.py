"""Controlled invariant subspaces: the largest in the kernel of the output, with its friends."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless, words
from compensator_theory._printing import text
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exceptional_factors import denominators_of, exceptional_factors
from compensator_theory.matrices._flint_matrices import identity_matrix, zero_matrix
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.placement._subspaces import Subspaces
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._canonical_forms import RealisationLike, realisation

IDENTITY = "(A + B F) V = V M, (C + D F) V = 0"


@dataclass(frozen=True)
class ControlledInvariantSubspaces(ExactValue):
    r"""The subspaces V*, R* and S* of a plant: zero output under feedback.

    .. math:: (A + BF)\,\mathcal{{V}}^* \subset \mathcal V^*, \qquad (C + DF)\,\mathcal V^* = 0

    Attributes
    ----------
    V : sympy.ImmutableMatrix
        A basis of V*, n x v, by columns; n x 0 where it is zero.
    R : sympy.ImmutableMatrix
        A basis of R*, the part of V* that inputs reach without leaving V*.
    S : sympy.ImmutableMatrix
        A basis of S*, the least conditioned invariant subspace that contains the image of B; with D
        = 0. R* is the intersection of V* and S*.
    F : sympy.ImmutableMatrix
        A friend, m x n.
    M : sympy.ImmutableMatrix
        (A + BF) V = V M.
    zero_polynomial : sympy.Poly
        Of the motion in V* modulo R*, whatever the friend: the invariant zeros.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    certificate : Certificate
        Both equations of the friend, evaluated anew. That V* is the largest is the recursion's end.
    """

    V: ImmutableMatrix
    R: ImmutableMatrix
    S: ImmutableMatrix
    F: ImmutableMatrix
    M: ImmutableMatrix
    zero_polynomial: Poly
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def __str__(self) -> str:
        return (
            f"V* = span {text(self.V.T.tolist())}, R* = span {text(self.R.T.tolist())}, "
            f"zeros of {text(self.zero_polynomial.as_expr())}"
        )

    def _repr_latex_(self) -> str:
        polynomial = self.zero_polynomial
        zeros = f"{words('zeros of ')} {latex(polynomial)}" if polynomial.degree() else ""
        return displayed(
            rf"\mathcal{{V}}^* = \operatorname{{im}} {latex(self.V)}",
            rf"\mathcal{{R}}^* = \operatorname{{im}} {latex(self.R)}",
            rf"\mathcal{{S}}^* = \operatorname{{im}} {latex(self.S)}",
            f"F = {latex(self.F)}",
            zeros,
            unless(self.exceptional),
        )


@carrying()
def controlled_invariant_subspaces(
    plant: RealisationLike, variable: str | Symbol | None = None
) -> ControlledInvariantSubspaces:
    r"""Find V*, R* and S* of a plant, with a friend of V*.

    .. math:: \mathcal V_0 = \mathbb R^n, \quad \mathcal V_{k+1} = \left\{x : \begin{bmatrix} A \\ C
              \end{bmatrix} x \in \begin{bmatrix} \mathcal V_k \\ 0 \end{bmatrix} + \mathrm{im}
              \begin{bmatrix} B \\ D \end{bmatrix}\right\}

    .. math:: \mathcal S_0 = 0, \quad \mathcal S_{k+1} = \begin{bmatrix} A & B \end{bmatrix} \left(
              (\mathcal S_k \oplus \mathbb R^m) \cap \ker \begin{bmatrix} C & D \end{bmatrix}\right)

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or input of :func:`realisation`
        With symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Raises
    ------
    InputError, ImproperError, BudgetError
        If the plant cannot be read, is improper, or too large.

    Notes
    -----
    Where V* is zero the plant is strongly observable: y determines x whatever u is. The dual
    subspaces are those of the transposed plant. Source: W. M. Wonham, Linear Multivariable Control
    (1985), Chapters 4 and 5; H. L. Trentelman, A. A. Stoorvogel, M. Hautus, Control Theory for
    Linear Systems (2001), Ch. 7.

    Examples
    --------
    >>> from compensator_theory.geometry import controlled_invariant_subspaces
    >>> A = [[0, 1, 0], [0, 0, 1], [-6, -11, -6]]
    >>> print(controlled_invariant_subspaces((A, [[0], [0], [1]], [[2, 1, 0]]), variable="s"))
    V* = span [[1, -2, 4]], R* = span [], zeros of s + 2
    """
    source = realisation(plant, variable)
    A, B, C, D = source.A, source.B, source.C, source.D
    n, m, p = source.n, B.cols, C.rows
    ask("entries", (n + p) * (2 * n + m), "the recursion of subspaces")
    work = Subspaces()
    V = _largest(work, A, B, C, D)
    S = _least(work, A, B, C, D)
    R = work.intersection(V, S) if V.cols and S.cols else zero_matrix(n, 0)
    R, V, S = (work.canonical(space) for space in (R, V, S))
    basis = work.sum(R, V) if R.cols else V
    M, inputs = _motion(work, (A, B, C, D), basis)
    F = _gain(work, basis, inputs, m)
    r = R.cols
    outside = characteristic_polynomial(ImmutableMatrix(M[r:, r:]), source.variable)
    left = [(A + B * F) * basis - basis * M, (C + D * F) * basis]
    divisors = [*work.divisors, *denominators_of((A, B, C, D, F, basis))]
    return ControlledInvariantSubspaces(
        basis, R, S, F, M, outside, exceptional_factors(divisors), certificate_of(IDENTITY, left)
    )


def _largest(
    work: Subspaces,
    A: ImmutableMatrix,
    B: ImmutableMatrix,
    C: ImmutableMatrix,
    D: ImmutableMatrix,
) -> ImmutableMatrix:
    n = A.rows
    V, both = identity_matrix(n), A.col_join(C)
    while V.cols:
        below = zero_matrix(C.rows, V.cols)
        after = work.preimage(both, V.col_join(below).row_join(B.col_join(D)))
        if after.cols == V.cols:
            break
        V = after
    return V


def _least(
    work: Subspaces,
    A: ImmutableMatrix,
    B: ImmutableMatrix,
    C: ImmutableMatrix,
    D: ImmutableMatrix,
) -> ImmutableMatrix:
    n = A.rows
    S = zero_matrix(n, 0)
    while True:
        zero_output = work.kernel((C * S).row_join(D))  # (t, u) with C S t + D u = 0
        after = work.span(ImmutableMatrix((A * S).row_join(B) * zero_output))
        if after.cols == S.cols:
            return after
        S = after


def _motion(
    work: Subspaces, plant: tuple[ImmutableMatrix, ...], V: ImmutableMatrix
) -> tuple[ImmutableMatrix, ImmutableMatrix]:
    """Return M and U with A V + B U = V M and C V + D U = 0."""
    A, B, C, D = plant
    if not V.cols:
        return zero_matrix(0, 0), zero_matrix(B.cols, 0)
    below = zero_matrix(C.rows, V.cols)
    wide = V.col_join(below).row_join(-B.col_join(D))
    motion = work.coordinates(wide, A.col_join(C) * V)
    assert motion is not None, "V* is controlled invariant"
    return ImmutableMatrix(motion[: V.cols, :]), ImmutableMatrix(motion[V.cols :, :])


def _gain(work: Subspaces, V: ImmutableMatrix, U: ImmutableMatrix, m: int) -> ImmutableMatrix:
    """Return F with F V = U."""
    if not V.cols:
        return zero_matrix(m, V.rows)
    gain = work.coordinates(V.T, U.T)
    assert gain is not None, "the columns of V are independent"
    return ImmutableMatrix(gain.T)
