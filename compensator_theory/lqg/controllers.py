"""The LQG controller: exact gains, Riccati solutions, closed-loop poles and compensator."""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import sympy
from sympy import ImmutableMatrix, Poly

from compensator_theory.errors import InputError
from compensator_theory.lqg.poles import LQGPoles
from compensator_theory.lqg.regulator_data import regulator_and_estimator
from compensator_theory.lqg.riccati import RiccatiSolution, solve_riccati
from compensator_theory.lqg.targets import scalar_numerators
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import time_of
from compensator_theory.roots.enclosures import PolynomialEnclosure
from compensator_theory.systems.standard_problems import StandardProblem
from compensator_theory.systems.state_space import transfer_matrix_of_realisation
from compensator_theory.transfer_functions.transfer_functions import TransferFunction

ControllerMatrices: TypeAlias = tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]


@dataclass(frozen=True)
class LQGController(ExactValue):
    r"""The LQG controller of a plant with one input and one output, with its certificates.

    .. math:: \mathrm{mspec}(\tilde A) = \mathrm{mspec}(A + BC_c) \cup \mathrm{mspec}(A - B_cC)

    Attributes
    ----------
    plant : StandardProblem
    regulator : RiccatiSolution
        (A.6), (A.7): P, the gain :math:`C_c` and the polynomial of :math:`A + BC_c`.
    estimator : RiccatiSolution
        (A.5), (A.8) as the dual regulator: its P is Q, its gain :math:`-B_c^T`.

    Examples
    --------
    >>> from compensator_theory import lqg_controller, standard_problem
    >>> print(lqg_controller(standard_problem("(q - 2)/(q**2 - 1/4)")))
    D = q**4 - q**3 + q**2/4
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
        """The closed-loop polynomial of degree 2n if it is rational, else None."""
        return self.poles.polynomial

    @property
    def enclosure(self) -> PolynomialEnclosure:
        """The closed-loop polynomial, certified."""
        return self.poles.enclosure

    @property
    def realisation(self) -> ControllerMatrices | None:
        r"""The matrices of (A.4)-(A.6) for u = G_c y if they are rational, else None.

        .. math:: C_c = K, \qquad B_c = -L^T, \qquad A_c = A + BC_c - B_cC - B_cD_0C_c
        """
        C_c, L, plant = self.regulator.K, self.estimator.K, self.plant
        if C_c is None or L is None:
            return None
        B_c = -L.T
        A_c = plant.A + plant.B * C_c - B_c * plant.C - B_c * plant.D_0 * C_c
        return ImmutableMatrix(A_c), ImmutableMatrix(B_c), ImmutableMatrix(C_c)

    @cached_property
    def compensator(self) -> TransferFunction | None:
        """The compensator of order n for u = G_c y if it is rational, else None."""
        matrices = self.realisation
        if matrices is None:
            return None
        direct = sympy.zeros(1, 1)
        return transfer_matrix_of_realisation(*matrices, direct, self.plant.variable).scalar()

    def __str__(self) -> str:
        if self.polynomial is None:
            return f"D = {self.enclosure}"
        return f"D = {format_polynomial(self.polynomial)}\nG_c = {self.compensator}"

    def _repr_latex_(self) -> str:
        return self.poles._repr_latex_()


def lqg_controller(plant: StandardProblem, *, digits: int = 30) -> LQGController:
    r"""Solve LQG exactly, or in certified balls where it is not rational.

    .. math:: \tilde D(s) = \det(sI - A - BC_c)\,\det(sI - A + B_cC)

    Parameters
    ----------
    plant : StandardProblem
        Rational, with scalar u and y, (A, B) controllable, (A, C) observable; its variable s, z or
        q says the time domain. In discrete time w and z are scalar too. In continuous time
        :math:`R_2 = E_2^TE_2` and :math:`V_2 = D_2D_2^T` are not zero. Cross terms are allowed.
    digits : int
        Where a factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.

    Returns
    -------
    LQGController

    Raises
    ------
    UnitCircleError
        If :math:`N_{zu}` or :math:`N_{yw}` has a zero on the unit circle.
    NoSolutionError
        If :math:`N_{zu} = 0` or :math:`N_{yw} = 0`; in continuous time if u or the sensor noise
        costs nothing (the gains are infinite then, see :func:`high_authority_limits`), or no
        solution is stabilising.
    NotControllableError
        If (A, B) is not controllable or (A, C) is not observable.
    InputError
        If a signal that must be scalar is not, an entry is symbolic, or the plant is not written in
        s, z or q.

    Notes
    -----
    Source: (A.4)-(A.17) and their counterpart in continuous time. With :math:`R_2 = 0` and
    :math:`V_2 = 0` in discrete time this is high-authority LQG,

    .. math::
        \tilde D_{HA} &= q^{d_{zu}} N_{zu,s} \bar N_{zu,u} \cdot
                          q^{d_{yw}} N_{yw,s} \bar N_{yw,u}, \qquad
        B^T P B = H_{d_{zu}}^2 \textstyle\prod |\text{zeros of } N_{zu,u}|^2

    where the bar is the monic polynomial with the reflected zeros. Errata: (A.15)-(A.17) print
    :math:`N_u(z^{-1})`, which has a pole of order :math:`n_u` at 0, so that n_u zeros are missing;
    the polynomials above have all n. For scalar z and w the formulas also hold with
    :math:`d_{zu} = 0` or :math:`d_{yw} = 0`, that is, with :math:`R_2 \ne 0`.

    Examples
    --------
    >>> from compensator_theory import StandardProblem, lqg_controller, standard_problem
    >>> found = lqg_controller(standard_problem("(q - 2)/(q**2 - 1/4)"))
    >>> found.regulator.P.tolist(), found.regulator.residual
    ([[4, -2], [-2, 4]], ((0, 0), (0, 0)))
    >>> plant = StandardProblem(A=[[0, 1], [0, 0]], B=[[0], [1]], C=[[1, 0]],
    ...     D_1=[[0, 0], [4, 0]], D_0=None, D_2=[[0, 1]],
    ...     E_1=[[1, 0], [0, 0]], E_2=[[0], ["1/2"]], E_0=None, variable="s")
    >>> found = lqg_controller(plant)
    >>> found.regulator.factor.polynomial.as_expr()
    s**2 + 2*s + 2
    >>> found.polynomial is None, found.enclosure.degree  # the estimator has sqrt(8) in it
    (True, 4)
    """
    sides = regulator_and_estimator(plant)
    s = plant.variable
    time = time_of(s, "LQG")
    if time == "discrete":
        scalar_numerators(plant)
    elif (plant.l_u, plant.l_y) != (1, 1):
        raise InputError(
            f"the plant has {plant.l_u} inputs and {plant.l_y} outputs; the exact gains are for "
            "one of each"
        )
    return LQGController(
        plant, *(solve_riccati(*side, time=time, digits=digits, variable=s) for side in sides)
    )
