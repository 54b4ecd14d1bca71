"""LQG closed-loop poles in continuous time, for any number of signals, by an exact determinant."""

from dataclasses import dataclass

from sympy import Poly

from compensator_theory.errors import (
    InputError,
    NoSolutionError,
)
from compensator_theory.latex import displayed
from compensator_theory.lqg.poles import require_stable_hidden_modes
from compensator_theory.lqg.regulator_spectra import continuous_regulator_spectrum
from compensator_theory.lqg.separation import enclosed_product, product_of_factors
from compensator_theory.polynomials.budget import shown
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import is_discrete
from compensator_theory.roots.counts import count_half_plane_roots
from compensator_theory.roots.enclosures import PolynomialEnclosure, latex_of, text_of
from compensator_theory.roots.half_plane_factors import HalfPlaneFactor, factor_even
from compensator_theory.systems.standard_problems import StandardProblem


@dataclass(frozen=True)
class ContinuousLQGPoles(ExactValue):
    r"""Where LQG puts the closed-loop poles in continuous time.

    .. math:: \mathrm{mspec}(\tilde A) = \mathrm{mspec}(A + BC_c) \cup \mathrm{mspec}(A - B_cC)

    Attributes
    ----------
    regulator, estimator : HalfPlaneFactor
        The polynomials of :math:`A + BC_c` and :math:`A - B_cC`, each of degree n.
    """

    regulator: HalfPlaneFactor
    estimator: HalfPlaneFactor

    @property
    def polynomial(self) -> Poly | None:
        """The closed-loop polynomial of degree 2n if it is rational, else None."""
        return product_of_factors(self.regulator, self.estimator)

    @property
    def enclosure(self) -> PolynomialEnclosure:
        """The closed-loop polynomial, certified."""
        return enclosed_product(self.regulator, self.estimator)

    def __str__(self) -> str:
        return f"D = {text_of(self.polynomial, self.enclosure)}"

    def _repr_latex_(self) -> str:
        return displayed(rf"\tilde D = {latex_of(self.polynomial, self.enclosure)}")


def continuous_lqg_poles(plant: StandardProblem, *, digits: int = 30) -> ContinuousLQGPoles:
    r"""Find the closed-loop poles of LQG in continuous time without solving a Riccati equation.

    Parameters
    ----------
    plant : StandardProblem
        Rational, written in s, any number of signals; :math:`R_2 = E_2^TE_2` and :math:`V_2 =
        D_2D_2^T` nonsingular, cross terms allowed.
    digits : int
        Where a factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.

    Returns
    -------
    ContinuousLQGPoles

    Raises
    ------
    NotControllableError, NotObservableError
        If a hidden mode is not left of the imaginary axis.
    NoSolutionError
        If :math:`R_2` or :math:`V_2` is singular, so that a gain is infinite, or a spectrum
        vanishes on the imaginary axis.
    InputError
        If an entry is symbolic, or the plant is not written in s.

    Notes
    -----
    Hidden modes left of the axis stay closed-loop poles. Source: (A.4)-(A.12), in continuous time.

    Examples
    --------
    >>> from compensator_theory import StandardProblem, continuous_lqg_poles
    >>> plant = StandardProblem(A=[[1, 0], [0, 2]], B=[[1, 0], [0, 1]], C=[[1, 0], [0, 1]],
    ...     D_1=[[0, 0, 0], [0, 0, 0]], D_0=None, D_2=[[1, 0, 0], [0, 1, 0]],
    ...     E_1=[[0, 0], [0, 0]], E_2=[[1, 0], [0, 1]], E_0=None, variable="s")
    >>> print(continuous_lqg_poles(plant))
    D = s**4 + 6*s**3 + 13*s**2 + 12*s + 4
    """
    if not isinstance(plant, StandardProblem):
        raise InputError(f"{shown(plant)} is not a StandardProblem; see standard_problem()")
    s = plant.variable
    if is_discrete(s, "LQG"):
        raise InputError(f"{s} means discrete time; use lqg_poles")
    require_stable_hidden_modes(plant, count_half_plane_roots, "left of the imaginary axis")
    data = (
        ("from u to z", "u", (plant.A, plant.B, plant.E_1, plant.E_2)),
        ("from w to y", "the sensor noise", (plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T)),
    )
    factors = []
    for name, weight, matrices in data:
        spectrum = continuous_regulator_spectrum(*matrices, s)
        if spectrum.is_zero or spectrum.degree() < 2 * plant.n:
            raise NoSolutionError(
                f"a combination of {weight} costs nothing, so that a gain is infinite; weight all "
                "of it, or see regulator_locus for the limits of the poles"
            )
        try:
            factors.append(factor_even(spectrum, digits))
        except NoSolutionError as error:
            raise NoSolutionError(
                f"the transfer matrix {name} has a zero on the imaginary axis, so that no LQG "
                f"controller is stabilising: {error}"
            ) from error
    return ContinuousLQGPoles(*factors)
