"""LQG in continuous time: exact gains, Riccati solutions, poles and compensator."""

from dataclasses import dataclass
from functools import cached_property

from sympy import Poly

from compensator_theory.errors import InputError
from compensator_theory.lqg.continuous.poles import ContinuousLQGPoles
from compensator_theory.lqg.continuous.riccati import (
    ContinuousRiccatiSolution,
    solve_continuous_riccati,
)
from compensator_theory.lqg.separation import (
    ControllerMatrices,
    controller_matrices,
    scalar_controller,
)
from compensator_theory.polynomials.budget import shown
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import is_discrete
from compensator_theory.roots.enclosures import PolynomialEnclosure
from compensator_theory.systems.standard_problems import StandardProblem
from compensator_theory.transfer_functions.transfer_functions import TransferFunction


@dataclass(frozen=True)
class ContinuousLQG(ExactValue):
    r"""The LQG controller of a plant in continuous time, with its certificates.

    .. math:: \mathrm{mspec}(\tilde A) = \mathrm{mspec}(A + BC_c) \cup \mathrm{mspec}(A - B_cC)

    Attributes
    ----------
    plant : StandardProblem
    regulator : ContinuousRiccatiSolution
        P, the gain :math:`C_c` and the polynomial of :math:`A + BC_c`.
    estimator : ContinuousRiccatiSolution
        As the dual regulator: its P is Q, its gain :math:`-B_c^T`.

    Examples
    --------
    >>> from compensator_theory import StandardProblem, continuous_lqg
    >>> plant = StandardProblem(A=[[0]], B=[[1]], C=[[1]], D_1=[[1, 0]], D_0=None, D_2=[[0, 1]],
    ...     E_1=[[2], [0]], E_2=[[0], [1]], E_0=None, variable="s")
    >>> print(continuous_lqg(plant))
    D = s**2 + 3*s + 2
    G_c = (-2)/(s + 3)
    """

    plant: StandardProblem
    regulator: ContinuousRiccatiSolution
    estimator: ContinuousRiccatiSolution

    @property
    def poles(self) -> ContinuousLQGPoles:
        """The two factors of the closed-loop polynomial."""
        return ContinuousLQGPoles(self.regulator.factor, self.estimator.factor)

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
        """The matrices (A_c, B_c, C_c) for u = G_c y if they are rational, else None."""
        return controller_matrices(self.plant, self.regulator.K, self.estimator.K)

    @cached_property
    def compensator(self) -> TransferFunction | None:
        """The compensator of order n for u = G_c y if it is rational, else None."""
        return scalar_controller(self.plant, self.realisation)

    def __str__(self) -> str:
        if self.polynomial is None:
            return f"D = {self.enclosure}"
        return f"D = {format_polynomial(self.polynomial)}\nG_c = {self.compensator}"

    def _repr_latex_(self) -> str:
        return self.poles._repr_latex_()


def continuous_lqg(plant: StandardProblem, *, digits: int = 30) -> ContinuousLQG:
    r"""Solve LQG in continuous time exactly, or in certified balls where it is not rational.

    .. math:: \tilde D(s) = \det(sI - A - BC_c)\,\det(sI - A + B_cC)

    Parameters
    ----------
    plant : StandardProblem
        Rational, written in s, one input u and one output y, any numbers of w and z;
        :math:`R_2 = E_2^TE_2` and :math:`V_2 = D_2D_2^T` not zero, cross terms allowed.
    digits : int
        Where a factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.

    Returns
    -------
    ContinuousLQG

    Raises
    ------
    NoSolutionError
        If u or the sensor noise costs nothing (the gains are infinite then, see
        :func:`regulator_locus` for the limits), or no solution is stabilising.
    NotControllableError
        If (A, B) is not controllable or (A, C) is not observable.
    InputError
        If u or y is not scalar, an entry is symbolic, or the plant is written in z or q.

    Notes
    -----
    Source: (A.4)-(A.12), in continuous time: dQ/dt = 0 in place of the difference equation.

    Examples
    --------
    >>> from compensator_theory import StandardProblem, continuous_lqg
    >>> plant = StandardProblem(A=[[0, 1], [0, 0]], B=[[0], [1]], C=[[1, 0]],
    ...     D_1=[[0, 0], [4, 0]], D_0=None, D_2=[[0, 1]],
    ...     E_1=[[1, 0], [0, 0]], E_2=[[0], ["1/2"]], E_0=None, variable="s")
    >>> found = continuous_lqg(plant)
    >>> found.regulator.factor.polynomial.as_expr()
    s**2 + 2*s + 2
    >>> found.polynomial is None, found.enclosure.degree  # the estimator has sqrt(8) in it
    (True, 4)
    """
    if not isinstance(plant, StandardProblem):
        raise InputError(f"{shown(plant)} is not a StandardProblem; see standard_problem()")
    s = plant.variable
    if is_discrete(s, "LQG"):
        raise InputError(f"{s} means discrete time; use lqg_poles or high_authority_lqg")
    if (plant.l_u, plant.l_y) != (1, 1):
        raise InputError(
            f"the plant has {plant.l_u} inputs and {plant.l_y} outputs; the exact gains are for "
            "one of each"
        )
    regulator = solve_continuous_riccati(
        plant.A, plant.B, plant.E_1, plant.E_2, digits=digits, variable=s
    )
    estimator = solve_continuous_riccati(
        plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T, digits=digits, variable=s
    )
    return ContinuousLQG(plant, regulator, estimator)
