"""A regulator and an observer joined to an observer-based compensator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import flint
from sympy import Expr, ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.loops._closed_loop_matrix import closed_loop_matrix
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._flint_matrices import (
    from_flint,
    is_rational_matrix,
    rational_in_flint,
)
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.matrices._linear_algebra import (
    determinant,
    in_lowest_terms,
    multiplied,
)
from compensator_theory.observers._gains import (
    observer_gain,
    read_target_polynomial,
    regulator_gain,
)
from compensator_theory.polynomials._budget import ask_for_number
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._from_roots import SpectrumLike
from compensator_theory.polynomials._generic_answers import generic_answer_of
from compensator_theory.polynomials._poly import canonical, is_rational
from compensator_theory.polynomials._substitution import denominators_in
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._controllability import controllability_matrix
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._state_space import fed_back_polynomial
from compensator_theory.systems._transfer_functions import TransferFunction

SIMILARITY = "S A~ = A' S, det(sI - A - B K) = p_R, det(sI - A + F C) = p_O"


@dataclass(frozen=True)
class ObserverBasedCompensator(ExactValue):
    r"""An observer followed by state-estimate feedback, with the proof of its spectrum.

    .. math:: \dot{\hat x} = (A + BK - FC)\hat x + F y, \qquad u = K\hat x

    Attributes
    ----------
    plant : Realisation
        (A, B, C), of order n.
    K, F : sympy.ImmutableMatrix
        Regulator gain 1 x n and observer gain n x 1.
    regulator, observer : sympy.Poly
        :math:`\det(sI - A - BK)` and :math:`\det(sI - A + FC)`.

    Notes
    -----
    Source: (7.11)-(7.18).
    """

    plant: Realisation
    K: ImmutableMatrix
    F: ImmutableMatrix
    regulator: Poly
    observer: Poly

    @property
    def compensator(self) -> Realisation:
        r"""The realisation (7.13), :math:`(A + BK - FC - F D_0 K,\ F,\ K)`, positive feedback."""
        plant, K, F = self.plant, self.K, self.F
        A, B, C, D = plant.matrices
        measured = C + multiplied(D, K)
        _ask_for_longest(A, B, K, F, measured)
        fed_back, injected = multiplied(B, K), multiplied(F, measured)
        A_c, period = in_lowest_terms(A + fed_back - injected), plant.sample_time
        return Realisation(A_c, F, K, None, plant.variable, sample_time=period)

    @property
    def transfer_function(self) -> TransferFunction:
        r""":math:`K(sI - A - BK + FC)^{-1}F` over the unreduced denominator, u = G_c y.

        Erratum: (7.31) is minus this; the negative feedback of (7.22) needs that sign.
        """
        fast = self._from_loop_polynomial()
        return self.compensator.transfer_function() if fast is None else fast

    def _from_loop_polynomial(self) -> TransferFunction | None:
        """Return N_c/D_c of D D_c - N N_c = p_R p_O; None with symbols, or of hidden modes.

        Of degrees n - 1 and n they are unique, and the numbers of A_c are much longer than theirs.
        """
        if not self.plant.n or not all(map(is_rational_matrix, self.plant.matrices)):
            return None
        if not (is_rational(self.characteristic_polynomial) and self._spectra_hold()):
            return None
        G = self.plant.transfer_function()
        N, D, goal = map(
            to_flint_polynomial, (G.numerator, G.denominator, self.characteristic_polynomial)
        )
        divisor, inverse, _ = N.xgcd(D)
        if divisor.degree() != 0:
            return None
        top = -goal * inverse % D
        bottom, remainder = divmod(goal + N * top, D)
        if remainder:
            return None
        residual = flint.fmpq_mat(1, 1, [int(D * bottom - N * top != goal)])
        proof = certificate_of("D D_c - N N_c = p_R p_O", [from_flint(residual)], "compensator")
        numerator, denominator = (
            from_flint_polynomial(p, self.plant.variable) for p in (top, bottom)
        )
        period = self.plant.sample_time
        return TransferFunction(numerator, denominator, sample_time=period, certificate=proof)

    def _spectra_hold(self) -> bool:
        """Tell whether both gains place the polynomials that stand beside them."""
        A, B, C, s = self.plant.A, self.plant.B, self.plant.C, self.plant.variable
        return bool(
            fed_back_polynomial(A, B, self.K, s) == self.regulator
            and fed_back_polynomial(A.T, C.T, -self.F.T, s) == self.observer
        )

    @property
    def characteristic_polynomial(self) -> Poly:
        r"""The closed-loop polynomial :math:`\tilde D`, regulator times observer."""
        return canonical(self.regulator * self.observer)

    @property
    def certificate(self) -> Certificate:
        r"""The certificate of (7.18): the loop has the regulator and the observer polynomial.

        :math:`\tilde S\tilde A - \tilde A'\tilde S`, computed anew from the loop of plant and
        compensator, and the residuals of both polynomials.
        """
        A, B, C, n = self.plant.A, self.plant.B, self.plant.C, self.plant.n
        joined = in_lowest_terms(closed_loop_matrix(self.plant, self.compensator))
        upper, lower = joined[:n, :], joined[n:, :]
        moved = multiplied(B, self.K)
        outer = in_lowest_terms(A - multiplied(self.F, C))
        s = self.plant.variable
        # The rows of S A~ and of A' S, whose products would be as slow as their numbers are long
        above = upper - A.row_join(moved)
        below = upper - lower - outer.row_join(-outer)
        left = [
            (fed_back_polynomial(A, B, self.K, s) - self.regulator).all_coeffs(),
            (fed_back_polynomial(A.T, C.T, -self.F.T, s) - self.observer).all_coeffs(),
        ]
        return certificate_of(SIMILARITY, [above, below, *left], "compensator")

    def __str__(self) -> str:
        return (
            f"K = {text(self.K.tolist())}: regulator {format_polynomial(self.regulator)}\n"
            f"F = {text(self.F.T.tolist())}': observer {format_polynomial(self.observer)}\n"
            f"u = G_c y, G_c = {self.transfer_function}"
        )

    def _repr_latex_(self) -> str:
        return displayed(
            f"K = {latex(self.K)}",
            f"F = {latex(self.F)}",
            f"G_c = {latex(self.transfer_function)}",
        )


def _ask_for_longest(A: Matrix, B: Matrix, K: Matrix, F: Matrix, measured: Matrix) -> None:
    """Refuse A + B K - F C by one entry, that of the longest numbers of K and F."""
    k, f = rational_in_flint(K), rational_in_flint(F)
    if k is None or f is None or not A.rows:
        return
    column, row = (
        max(range(A.rows), key=[entry.height_bits() for entry in gain.entries()].__getitem__)
        for gain in (k, f)
    )
    entry = A[row, column] + B[row, 0] * K[0, column] - F[row, 0] * measured[0, column]
    if entry.is_Rational:
        subject = "A + B K - F C of the compensator, longer than its transfer_function,"
        ask_for_number(int(entry.p), int(entry.q), subject)


@carrying(real=True)
def observer_based_compensator(
    plant: RealisationLike,
    regulator_poles: SpectrumLike,
    observer_poles: SpectrumLike,
    *,
    variable: str | Symbol | None = None,
) -> ObserverBasedCompensator:
    r"""Design a regulator and an observer with given spectra.

    .. math:: \det(sI - A - BK) = p_R, \qquad \det(sI - A + FC) = p_O

    Parameters
    ----------
    plant : realisation
        SISO, of order n; anything :func:`realisation` reads; symbols allowed. With
        :math:`D_0 \ne 0` the observer subtracts :math:`D_0 u` from the measurement.
    regulator_poles, observer_poles : polynomial or list of roots
        Of degree n; a list holds the *roots*.
    variable : str or Symbol, optional
        Of the plant; default: evident, bare matrices need it.

    Returns
    -------
    ObserverBasedCompensator
        By Proposition 1 its transfer function depends on :math:`p_R p_O` alone. The
        text's proof claims :math:`\deg N_c = n-1`; true is :math:`\deg N_c \le n-1`.

    Raises
    ------
    NotControllableError, NotObservableError
        If the plant has hidden modes; the message names their polynomial.
    InputError
        If the plant is not SISO, or the numbers of poles do not fit.

    Notes
    -----
    Source: (7.11)-(7.18), (7.25)-(7.30), Proposition 1.

    Examples
    --------
    >>> from compensator_theory import observer_based_compensator
    >>> plant = ([[-1, 4], [0, -3]], [[0], [1]], [[1, 0]])
    >>> print(observer_based_compensator(plant, [-5, -4], [-2, -6], variable="s"))  # Example 7.1
    K = [[-3, -5]]: regulator s**2 + 9*s + 20
    F = [[4, -3/4]]': observer s**2 + 8*s + 12
    u = G_c y, G_c = (-33*s/4 - 93/4)/(s**2 + 13*s + 49)
    """
    system = realisation(plant, variable)
    s, n = system.variable, system.n
    if not system.is_siso:
        raise InputError(
            f"the plant has {system.B.cols} inputs and {system.C.rows} outputs; for several call "
            "stabilising_compensators(plant, regulator_poles, observer_poles, feedback=1)"
        )
    p_R, p_O = (read_target_polynomial(poles, n, s) for poles in (regulator_poles, observer_poles))
    K = regulator_gain(system.A, system.B, p_R, variable=s)
    F = observer_gain(system.A, system.C, p_O, variable=s)
    return ObserverBasedCompensator(system, K, F, p_R, p_O)


@generic_answer_of(observer_based_compensator)
def _generic_compensator(
    plant: RealisationLike, *arguments: Any, **options: Any
) -> tuple[ObserverBasedCompensator, list[Expr]]:
    """Return the compensator and its condition: a controllable and observable plant."""
    compensator = observer_based_compensator(plant, *arguments, **options)
    A, B, C, _ = compensator.plant.matrices
    ranks = [determinant(controllability_matrix(*pair)) for pair in ((A, B), (A.T, C.T))]
    return compensator, [*ranks, *denominators_in(compensator)]
