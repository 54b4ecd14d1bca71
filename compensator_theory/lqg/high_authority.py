"""High-authority LQG: exact gains, exact Riccati solutions, exact closed-loop poles."""

from dataclasses import dataclass
from functools import cached_property

from sympy import Poly

from compensator_theory.lqg.poles import LQGPoles
from compensator_theory.lqg.riccati import RiccatiSolution, solve_riccati
from compensator_theory.lqg.separation import (
    ControllerMatrices,
    controller_matrices,
    scalar_controller,
)
from compensator_theory.lqg.targets import scalar_numerators
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.roots.enclosures import PolynomialEnclosure
from compensator_theory.systems.standard_problems import StandardProblem
from compensator_theory.transfer_functions.transfer_functions import TransferFunction


@dataclass(frozen=True)
class HighAuthorityLQG(ExactValue):
    r"""The LQG controller with :math:`R_2 = 0` and :math:`V_2 = 0`, with its certificates.

    .. math:: \tilde D_{HA} = q^{d_{zu}} N_{zu,s} \bar N_{zu,u} \cdot
                              q^{d_{yw}} N_{yw,s} \bar N_{yw,u}

    where the bar is the monic polynomial with the reflected zeros.

    Attributes
    ----------
    plant : StandardProblem
    regulator : RiccatiSolution
        (A.6), (A.7): P, the gain :math:`C_c` and the polynomial of :math:`A + BC_c`.
    estimator : RiccatiSolution
        (A.5), (A.8) as the dual regulator: its P is Q, its gain :math:`-B_c^T`.

    Examples
    --------
    >>> from compensator_theory import high_authority_lqg, standard_problem
    >>> print(high_authority_lqg(standard_problem("(q - 2)/(q**2 - 1/4)")))
    D_HA = q**4 - q**3 + q**2/4
    G_c = (-q/10 + 1/20)/(q**2 - q + 2/5)
    """

    plant: StandardProblem
    regulator: RiccatiSolution
    estimator: RiccatiSolution

    @property
    def poles(self) -> LQGPoles:
        """The two factors of the closed-loop polynomial."""
        return LQGPoles(self.regulator.factor, self.estimator.factor)

    @property
    def polynomial(self) -> Poly | None:
        r"""The polynomial :math:`\tilde D_{HA}` of degree 2n if it is rational, else None."""
        return self.poles.polynomial

    @property
    def enclosure(self) -> PolynomialEnclosure:
        r"""The polynomial :math:`\tilde D_{HA}`, certified."""
        return self.poles.enclosure

    @property
    def realisation(self) -> ControllerMatrices | None:
        """The matrices (A_c, B_c, C_c) of (A.4)-(A.6) if they are rational, else None."""
        return controller_matrices(self.plant, self.regulator.K, self.estimator.K)

    @cached_property
    def compensator(self) -> TransferFunction | None:
        """The compensator of order n for u = G_c y if it is rational, else None."""
        return scalar_controller(self.plant, self.realisation)

    def __str__(self) -> str:
        if self.polynomial is None:
            innovations = (self.regulator.factor.constant, self.estimator.factor.constant)
            values = "B'PB = {!r}\nCQC' = {!r}".format(*innovations)
            return f"D_HA = {self.enclosure}\n{values}"
        return f"D_HA = {format_polynomial(self.polynomial)}\nG_c = {self.compensator}"

    def _repr_latex_(self) -> str:
        return self.poles._repr_latex_().replace(r"\tilde D", r"\tilde D_{HA}")


def high_authority_lqg(plant: StandardProblem, *, digits: int = 30) -> HighAuthorityLQG:
    r"""Solve high-authority LQG exactly, or in certified balls where it is not rational.

    .. math::
        \det(qI - A - BC_c) &= q^{d_{zu}}\, N_{zu,s}\; q^{n_u} N_{zu,u}(1/q) / N_{zu,u}(0) \\
        B^T P B &= H_{d_{zu}}^2 \textstyle\prod |\text{zeros of } N_{zu,u}|^2

    and likewise for :math:`A - B_cC` with :math:`N_{yw}`.

    Parameters
    ----------
    plant : StandardProblem
        Rational, with scalar signals, (A, B) controllable, (A, C) observable.
    digits : int
        Where a numerator does not split over the rationals, every radius is at most
        :math:`10^{-\mathrm{digits}}`.

    Returns
    -------
    HighAuthorityLQG

    Raises
    ------
    UnitCircleError
        If :math:`N_{zu}` or :math:`N_{yw}` has a zero on the unit circle.
    NoSolutionError
        If :math:`N_{zu} = 0` or :math:`N_{yw} = 0`.
    NotControllableError
        If (A, B) is not controllable or (A, C) is not observable.
    InputError
        If a signal is not scalar, an entry is symbolic, or the plant is not written in z or q.

    Notes
    -----
    Source: (A.4)-(A.17). Errata: (A.15)-(A.17) print :math:`N_u(z^{-1})`, which has a pole of order
    :math:`n_u` at 0, so that n_u zeros are missing; the polynomials above have all n. For scalar
    z and w the formulas also hold with :math:`d_{zu} = 0` or :math:`d_{yw} = 0`, that is, with
    :math:`R_2 \ne 0`, and the cross term is then taken into account.

    Examples
    --------
    >>> from compensator_theory import high_authority_lqg, standard_problem
    >>> found = high_authority_lqg(standard_problem("(q - 2)/(q**2 - 1/4)"))
    >>> found.regulator.P.tolist(), found.regulator.residual
    ([[4, -2], [-2, 4]], ((0, 0), (0, 0)))
    """
    scalar_numerators(plant)
    q = plant.variable
    regulator = solve_riccati(plant.A, plant.B, plant.E_1, plant.E_2, digits=digits, variable=q)
    estimator = solve_riccati(
        plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T, digits=digits, variable=q
    )
    return HighAuthorityLQG(plant, regulator, estimator)
