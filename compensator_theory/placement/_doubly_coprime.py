"""Doubly coprime fractions over the stable proper rational functions, from state feedback."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.errors import InputError
from compensator_theory.forms._minimal_realisations import minimal_realisation
from compensator_theory.matrices._certificates import Certified, Residuals, proven
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import (
    identity_matrix,
    rational_in_flint,
    zero_matrix,
)
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    in_lowest_terms,
)
from compensator_theory.placement._gain_families import state_feedback_family
from compensator_theory.placement._observer_gain_families import observer_gain_family
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._from_roots import SpectrumLike
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import time_of
from compensator_theory.roots._stability import decide_stability
from compensator_theory.systems._canonical_forms import RealisationLike, timed_realisation
from compensator_theory.systems._descriptions import has_states
from compensator_theory.systems._matrix_conversions import TransferMatrixLike
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._state_space import (
    require_few_terms,
    transfer_matrix_of_realisation,
)
from compensator_theory.systems._transfer_matrices import TransferMatrix


@dataclass(frozen=True)
class DoublyCoprimeFractions(Certified, ExactValue):
    r"""A plant as fractions of stable proper transfer matrices, with the identity of both.

    .. math:: G = N_r M_r^{-1} = M_l^{-1} N_l, \qquad
              \begin{bmatrix} V_l & -U_l \\ -N_l & M_l \end{bmatrix}
              \begin{bmatrix} M_r & U_r \\ N_r & V_r \end{bmatrix} = I

    Attributes
    ----------
    plant : Realisation
        (A, B, C, D), minimal or at least controllable and observable where it has to be moved.
    K, F : sympy.ImmutableMatrix
        Gains of state feedback and observer, A + B K and A - F C stable.
    M_r, N_r, U_r, V_r : TransferMatrix
        Over det(sI - A - BK).
    M_l, N_l, U_l, V_l : TransferMatrix
        Over det(sI - A + FC).
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    """

    identity = "[[V_l, -U_l], [-N_l, M_l]] [[M_r, U_r], [N_r, V_r]] = I"

    plant: Realisation
    K: ImmutableMatrix
    F: ImmutableMatrix
    M_r: TransferMatrix
    N_r: TransferMatrix
    U_r: TransferMatrix
    V_r: TransferMatrix
    M_l: TransferMatrix
    N_l: TransferMatrix
    U_l: TransferMatrix
    V_l: TransferMatrix
    exceptional: tuple[Expr, ...]

    def _residuals(self) -> Residuals:
        m, p = self.M_r.shape[0], self.M_l.shape[0]
        left = [
            self.V_l @ self.M_r - self.U_l @ self.N_r - identity_matrix(m),
            self.V_l @ self.U_r - self.U_l @ self.V_r,
            self.M_l @ self.N_r - self.N_l @ self.M_r,
            self.M_l @ self.V_r - self.N_l @ self.U_r - identity_matrix(p),
        ]
        return [[e.as_expr() for row in part.numerators for e in row] for part in left]

    def __str__(self) -> str:
        return f"G = ({self.N_r}) ({self.M_r})^-1 = ({self.M_l})^-1 ({self.N_l})"

    def _repr_latex_(self) -> str:
        right = rf"{latex(self.N_r)} \left({latex(self.M_r)}\right)^{{-1}}"
        left = rf"\left({latex(self.M_l)}\right)^{{-1}} {latex(self.N_l)}"
        return displayed(
            rf"G = N_r M_r^{{-1}} = {right} = M_l^{{-1}} N_l = {left}", unless(self.exceptional)
        )


@carrying(real=True)
def doubly_coprime_fractions(
    plant: RealisationLike | TransferMatrixLike,
    regulator: SpectrumLike,
    observer: SpectrumLike,
    *,
    variable: str | Symbol | None = None,
) -> DoublyCoprimeFractions:
    r"""Write a plant as doubly coprime fractions over the stable proper rational functions.

    .. math:: \begin{bmatrix} M_r & U_r \\ N_r & V_r \end{bmatrix} =
              \begin{bmatrix} I & 0 \\ D & I \end{bmatrix} +
              \begin{bmatrix} K \\ C + DK \end{bmatrix} (sI - A - BK)^{-1}
              \begin{bmatrix} B & F \end{bmatrix}

    Parameters
    ----------
    plant : realisation or transfer matrix
        Proper; a transfer matrix is realised with the least number of states, n.
    regulator, observer : polynomial or list of roots
        Of degree n, stable: the eigenvalues of A + B K and of A - F C.
    variable : str or Symbol, optional
        As for the readers.

    Raises
    ------
    NotControllableError, NotObservableError
        If a realisation that was given has hidden modes.
    InputError
        If a target spectrum is not stable, or the variable does not show the time domain.

    Notes
    -----
    Source: C. N. Nett, C. A. Jacobson and M. J. Balas, IEEE Transactions on Automatic Control 29
    (1984); K. Zhou, J. C. Doyle and K. Glover, Robust and Optimal Control (1996), Theorem 5.6. The
    signs are those of positive feedback, u = C y.

    Examples
    --------
    >>> from compensator_theory import doubly_coprime_fractions
    >>> fractions = doubly_coprime_fractions("1/(s**2 - s - 2)", [-1, -1], [-1, -1])
    >>> print(fractions.N_r, fractions.V_r)
    [[1]]/(s**2 + 2*s + 1) [[s**2 + 5*s + 13]]/(s**2 + 2*s + 1)
    """
    source, exceptional = read_plant(plant, variable)
    s, n = source.variable, source.n
    A, B, C, D = source.A, source.B, source.C, source.D
    if n:
        _require_short_work(source)
        feedback = state_feedback_family(A, B, regulator, variable=s)
        injection = observer_gain_family(A, C, observer, variable=s)
        K, F = feedback.gain(), injection.gain()
        exceptional += (*feedback.exceptional, *injection.dual.exceptional)
        bottoms = [sympy.fraction(sympy.cancel(e))[1] for e in (*K, *F)]
        exceptional = exceptional_factors([*exceptional, *bottoms])
    else:
        K, F = zero_matrix(B.cols, 0), zero_matrix(0, C.rows)
    m, p = B.cols, C.rows
    right = in_lowest_terms(A + B * K)
    left = in_lowest_terms(A - F * C)
    for closed, name in ((right, "regulator"), (left, "observer")):
        require_few_terms(closed, 8)
        require_stable(closed, s, name)
    eye_m, eye_p = identity_matrix(m), identity_matrix(p)
    first = transfer_matrix_of_realisation(
        right,
        B.row_join(F),
        K.col_join(in_lowest_terms(C + D * K)),
        Matrix.vstack(eye_m.row_join(sympy.zeros(m, p)), D.row_join(eye_p)),
        s,
        source.sample_time,
    )
    second = transfer_matrix_of_realisation(
        left,
        in_lowest_terms(-(B - F * D)).row_join(-F),
        K.col_join(C),
        Matrix.vstack(eye_m.row_join(sympy.zeros(m, p)), (-D).row_join(eye_p)),
        s,
        source.sample_time,
    )
    M_r, U_r, N_r, V_r = _blocks(first, m)
    V_l, minus_U_l, minus_N_l, M_l = _blocks(second, m)
    result = DoublyCoprimeFractions(
        source, K, F, M_r, N_r, U_r, V_r, M_l, -minus_N_l, -minus_U_l, V_l, exceptional
    )
    proven(result.certificate, "pair of fractions")
    return result


def _require_short_work(plant: Realisation) -> None:
    """Check the budget for the polynomials of A + BK and A - FC, whose numbers are long."""
    raw = rational_in_flint(plant.A.row_join(plant.B).col_join(plant.C.row_join(plant.D)))
    if raw is not None:
        numerators, below = raw.numer_denom()
        bits = max((abs(e).bit_length() for e in numerators.entries()), default=0)
        work = plant.n**5 * int(bits + below.bit_length()) // 500
        ask("entries", work, f"the fractions of a plant of order {plant.n}, digit by digit,")


def read_plant(
    plant: RealisationLike | TransferMatrixLike, variable: str | Symbol | None
) -> tuple[Realisation, tuple[Expr, ...]]:
    """Return a realisation: the one that was given, or a minimal one of a transfer matrix."""
    if has_states(plant, variable):
        return timed_realisation(plant, variable, "a stable fraction"), ()
    minimal = minimal_realisation(plant, variable)
    return minimal.realisation, minimal.exceptional


def require_stable(matrix: ImmutableMatrix, variable: Symbol, name: str) -> None:
    """Refuse an unstable matrix; accept one whose stability depends on symbols."""
    polynomial = characteristic_polynomial(matrix, variable)
    if decide_stability(polynomial, time=time_of(variable, "stability")).is_stable is False:
        raise InputError(
            f"the {name} spectrum {format_polynomial(polynomial)} is not stable; the fractions "
            "need stable denominators"
        )


def _blocks(
    whole: TransferMatrix, size: int
) -> tuple[TransferMatrix, TransferMatrix, TransferMatrix, TransferMatrix]:
    def block(rows: slice, columns: slice) -> TransferMatrix:
        part = tuple(row[columns] for row in whole.numerators[rows])
        return TransferMatrix(part, whole.denominator, sample_time=whole.sample_time)

    low, high = slice(None, size), slice(size, None)
    return block(low, low), block(low, high), block(high, low), block(high, high)
