"""Every stabilising compensator of a plant, by a stable parameter, and the closed-loop maps."""

from __future__ import annotations

from dataclasses import dataclass, replace

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.errors import ImproperError, InputError, NoSolutionError
from compensator_theory.forms._coprime_fractions import coprime_fractions
from compensator_theory.loops._siso import require_sign
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    in_lowest_terms,
    solve,
)
from compensator_theory.placement._doubly_coprime import (
    DoublyCoprimeFractions,
    doubly_coprime_fractions,
    read_plant,
)
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._from_roots import SpectrumLike
from compensator_theory.polynomials._letters import fresh, names_in_all
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import is_operator, time_of
from compensator_theory.roots._stability import decide_stability
from compensator_theory.systems._canonical_forms import RealisationLike
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._sample_times import shared_sample_time
from compensator_theory.systems._transfer_matrices import TransferMatrix


@dataclass(frozen=True)
class AffineMap(ExactValue):
    r"""A closed-loop map as a function of the parameter, :math:`H_0 + H_1 Q H_2`.

    Attributes
    ----------
    H_0, H_1, H_2 : TransferMatrix
        Stable and proper.
    """

    _CARRIES = True

    H_0: TransferMatrix
    H_1: TransferMatrix
    H_2: TransferMatrix

    def __call__(self, Q: TransferMatrix) -> TransferMatrix:
        """Return the map for one parameter, without common factors."""
        return (self.H_0 + self.H_1 @ Q @ self.H_2).reduced()

    def _repr_latex_(self) -> str:
        Q = latex(fresh(names_in_all(self), "Q"))
        return displayed(f"{latex(self.H_0)} + {latex(self.H_1)}\\, {Q}\\, {latex(self.H_2)}")


@dataclass(frozen=True)
class StabilisingCompensators(ExactValue):
    r"""All compensators that stabilise a plant, by a parameter Q.

    .. math:: f\,C = (U_r + M_r Q)(V_r + N_r Q)^{-1} = (V_l + Q N_l)^{-1}(U_l + Q M_l)

    C stabilises G with u = f C y if and only if Q is stable and proper and
    :math:`\det(I + D\,Q(\infty)) \ne 0`.

    Attributes
    ----------
    fractions : DoublyCoprimeFractions
        Of the plant, over its stable denominators, with the certificate.
    feedback : {+1, -1}
        The sign f.
    """

    _CARRIES = "reals"

    fractions: DoublyCoprimeFractions
    feedback: int

    @property
    def plant(self) -> Realisation:
        """The realisation (A, B, C, D) that the compensators are made from."""
        return self.fractions.plant

    @property
    def exceptional(self) -> tuple[Expr, ...]:
        """Polynomials in the symbols; everything holds where none of them is zero."""
        return self.fractions.exceptional

    @property
    def certificate(self) -> Certificate:
        """The Bezout identity of the fractions, from which all compensators come."""
        return self.fractions.certificate

    def compensator(self, Q: RealisationLike | TransferMatrixLike | None = None) -> Realisation:
        r"""Return the compensator of one parameter: an observer, its gain, and Q on the innovation.

        .. math:: \dot{\hat x} &= A \hat x + B u + F e, \qquad e = y - C \hat x - D u, \\
                  u &= K \hat x + Q e

        Parameters
        ----------
        Q : transfer matrix or realisation, optional
            m x p and proper; default 0. Stable or not: where it is not, the loop is unstable, with
            the poles of Q.

        Returns
        -------
        Realisation
            Of order n plus that of Q, with the sign of the loop. Hidden modes are possible.

        Raises
        ------
        ImproperError
            If Q is improper or det(I + D Q(oo)) = 0.
        InputError
            If its shape or variable does not fit.
        """
        q, plant = self._parameter(Q), self.plant
        K, F, D = self.fractions.K, self.fractions.F, plant.D
        direct = identity_matrix(plant.C.rows) + D * q.D
        try:
            R = solve(direct, identity_matrix(direct.rows))
        except NoSolutionError as error:
            raise ImproperError(
                "det(I + D Q(oo)) = 0: the loop of this parameter is not well posed, and its "
                "compensator is improper; change the direct term of Q"
            ) from error
        on_x, on_q = -R * (plant.C + D * K), -R * D * q.C
        into = plant.B * q.D + F
        A = Matrix.vstack(
            (plant.A + plant.B * K + into * on_x).row_join(plant.B * q.C + into * on_q),
            (q.B * on_x).row_join(q.A + q.B * on_q),
        )
        B = Matrix.vstack(into * R, q.B * R)
        C = (K + q.D * on_x).row_join(q.C + q.D * on_q)
        a, b, c, d = (
            in_lowest_terms(x) for x in (A, B, self.feedback * C, self.feedback * q.D * R)
        )
        return Realisation(
            a, b, c, d, plant.variable, feedback=self.feedback,
            sample_time=shared_sample_time(plant, q),
        )  # fmt: skip

    def closed_loop_polynomial(self, Q: RealisationLike | TransferMatrixLike | None = None) -> Poly:
        """Return det(sI - A - BK) det(sI - A + FC) det(sI - A_q), the poles of that loop."""
        q = self._parameter(Q)
        return canonical(
            self.fractions.M_r.denominator
            * self.fractions.M_l.denominator
            * characteristic_polynomial(q.A, self.plant.variable)
        )

    def closed_loop_map(self) -> AffineMap:
        r"""Return the map from signals added to y and u, to y and u; it is affine in Q.

        .. math:: \begin{bmatrix} (I - GC)^{-1} & G(I - CG)^{-1} \\
                  C(I - GC)^{-1} & (I - CG)^{-1} \end{bmatrix} =
                  \begin{bmatrix} V_r \\ U_r \end{bmatrix}
                  \begin{bmatrix} M_l & N_l \end{bmatrix} +
                  \begin{bmatrix} 0 & 0 \\ 0 & I \end{bmatrix} +
                  \begin{bmatrix} N_r \\ M_r \end{bmatrix} Q
                  \begin{bmatrix} M_l & N_l \end{bmatrix}

        with f C for C. The sensitivity function is its first p x p block.
        """
        f = self.fractions
        p, m = f.N_r.shape
        joined_rows = tuple(x + y for x, y in zip(f.M_l.numerators, f.N_l.numerators, strict=True))
        from_signals = replace(f.M_l, numerators=joined_rows)
        central = replace(f.V_r, numerators=f.V_r.numerators + f.U_r.numerators)
        to_signals = replace(f.N_r, numerators=f.N_r.numerators + f.M_r.numerators)
        constant = sympy.diag(sympy.zeros(p, p), identity_matrix(m))
        return AffineMap(
            (central @ from_signals + constant).reduced(),
            to_signals.reduced(),
            from_signals.reduced(),
        )

    def parameter(self, compensator: TransferMatrixLike) -> TransferMatrix:
        r"""Return the Q of a compensator, :math:`Q = (M_r - f C N_r)^{-1}(f C V_r - U_r)`.

        Raises
        ------
        InputError
            If the shape does not fit, or the loop has no solution: det(I - f C G) = 0.
        """
        f = self.fractions
        C = self.feedback * transfer_matrix(compensator, self.plant.variable).reduced()
        if C.shape != f.N_r.shape[::-1]:
            raise InputError(f"the compensator is {C.shape}; this plant needs {f.N_r.shape[::-1]}")
        try:
            inverse = (f.M_r - C @ f.N_r).inverse()
        except InputError as error:
            raise InputError(f"det(I - f C G) = 0 with {compensator}: no loop is closed") from error
        return (inverse @ (C @ f.V_r - f.U_r)).reduced()

    def stabilises(self, compensator: TransferMatrixLike) -> bool | None:
        """Tell whether a compensator without hidden modes stabilises the plant.

        It does where its parameter is stable and proper, and it is proper itself; None where that
        depends on symbols.
        """
        Q = self.parameter(compensator)
        C = transfer_matrix(compensator, self.plant.variable)
        proper = [
            G[i, j].is_proper for G in (C, Q) for i in range(C.shape[0]) for j in range(C.shape[1])
        ]
        poles = coprime_fractions(Q).pole_polynomial
        decision = decide_stability(poles, time=time_of(Q.variable, "stability"))
        verdicts = [*proper, decision.is_stable]
        return False if False in verdicts else None if None in verdicts else True

    def _parameter(self, Q: RealisationLike | TransferMatrixLike | None) -> Realisation:
        plant = self.plant
        p, m = plant.D.shape
        if Q is None:
            zeros = ImmutableMatrix.zeros
            return Realisation(zeros(0, 0), zeros(0, p), zeros(m, 0), zeros(m, p), plant.variable)
        parameter = read_plant(Q, plant.variable)[0]
        if parameter.D.shape != (m, p):
            raise InputError(f"the parameter is {parameter.D.shape}; this plant needs {(m, p)}")
        symbols = {parameter.variable}.union(
            *(x.free_symbols for x in (parameter.A, parameter.C, parameter.D))
        )
        if any(is_operator(symbol) and symbol != plant.variable for symbol in symbols):
            raise InputError(
                f"the parameter {Q} must be in {plant.variable}, the variable of the plant"
            )
        return parameter

    def __str__(self) -> str:
        f = self.fractions
        poles = format_polynomial(canonical(f.M_r.denominator * f.M_l.denominator))
        sign = "" if self.feedback == 1 else "-"
        return (
            f"{sign}C = (U_r + M_r Q)(V_r + N_r Q)^-1 with stable proper Q, poles of the loop "
            f"{poles} and those of Q"
        )

    def _repr_latex_(self) -> str:
        f, sign = self.fractions, "" if self.feedback == 1 else "-"
        Q = latex(fresh(names_in_all(f), "Q"))
        top = rf"\left({latex(f.U_r)} + {latex(f.M_r)} {Q}\right)"
        below = rf"\left({latex(f.V_r)} + {latex(f.N_r)} {Q}\right)^{{-1}}"
        return displayed(
            rf"{sign}C = (U_r + M_r {Q})(V_r + N_r {Q})^{{-1}} = {top} {below}",
            unless(f.exceptional),
        )


@carrying(real=True)
def stabilising_compensators(
    plant: RealisationLike | TransferMatrixLike,
    regulator: SpectrumLike,
    observer: SpectrumLike,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> StabilisingCompensators:
    r"""Find all compensators that stabilise a plant, SISO or MIMO (Youla and Kucera).

    Parameters
    ----------
    plant, regulator, observer, variable
        As for :func:`doubly_coprime_fractions`. Another choice of the two spectra gives the same
        set of compensators, by another parameter.
    feedback : {+1, -1}
        The sign f in u = f C y.

    Raises
    ------
    NotControllableError, NotObservableError, InputError
        As :func:`doubly_coprime_fractions`; InputError if `feedback` is neither +1 nor -1.

    Notes
    -----
    Source: D. C. Youla, H. A. Jabr and J. J. Bongiorno, IEEE Transactions on Automatic Control 21
    (1976); V. Kucera, Discrete Linear Control (1979); M. Vidyasagar, Control System Synthesis
    (1985), Theorem 5.2.1.

    Examples
    --------
    >>> from compensator_theory import stabilising_compensators
    >>> every = stabilising_compensators("1/(s**2 - s - 2)", [-1, -1], [-1, -1], feedback=1)
    >>> print(every.compensator().transfer_function())
    (-27*s - 27)/(s**2 + 5*s + 13)
    >>> print(every.compensator("-13").transfer_function())  # the one with an integrator
    (-13*s**2 - 14*s - 1)/(s**2 + 5*s)
    >>> print(every.parameter("-27*(s + 1)/(s**2 + 5*s + 13)"))
    [[0]]/(1)
    >>> every.stabilises("-3/(s + 1)")
    False
    """
    require_sign(feedback)
    fractions = doubly_coprime_fractions(plant, regulator, observer, variable=variable)
    return StabilisingCompensators(fractions, feedback)
