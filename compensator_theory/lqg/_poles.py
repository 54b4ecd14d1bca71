"""LQG closed-loop poles of plants with any number of signals, by an exact determinant."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Poly

from compensator_theory._latex import displayed
from compensator_theory.errors import (
    NoSolutionError,
    NotControllableError,
    NotObservableError,
    UnitCircleError,
)
from compensator_theory.lqg._regulator_data import regulator_and_estimator
from compensator_theory.lqg._regulator_spectra import regulator_spectrum
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time, time_of
from compensator_theory.roots._counts import count_roots
from compensator_theory.roots._enclosures import PolynomialEnclosure, latex_of, text_of
from compensator_theory.roots._spectral_factors import SpectralFactor, factor_spectrum
from compensator_theory.roots._unit_circle_enclosures import multiply_enclosures
from compensator_theory.systems._controllability import uncontrollable_polynomial
from compensator_theory.systems._standard_problems import StandardProblem


@dataclass(frozen=True)
class LQGPoles(ExactValue):
    r"""The closed-loop poles of LQG.

    .. math:: \mathrm{mspec}(\tilde A) = \mathrm{mspec}(A + BC_c) \cup \mathrm{mspec}(A - B_cC)

    Attributes
    ----------
    regulator, estimator : SpectralFactor
        The polynomials of :math:`A + BC_c` and :math:`A - B_cC`, each of degree n.

    Notes
    -----
    Source: (A.11).

    Examples
    --------
    >>> from compensator_theory import lqg_poles, standard_problem
    >>> print(lqg_poles(standard_problem("(q - 2)/(q**2 - 1/4)")))
    regulator: q**2 - q/2
    estimator: q**2 - q/2
    """

    regulator: SpectralFactor
    estimator: SpectralFactor

    @property
    def polynomial(self) -> Poly | None:
        """The closed-loop polynomial of degree 2n if it is rational, else None."""
        if self.regulator.polynomial is None or self.estimator.polynomial is None:
            return None
        return canonical(self.regulator.polynomial * self.estimator.polynomial)

    @property
    def enclosure(self) -> PolynomialEnclosure:
        """The closed-loop polynomial, certified."""
        return multiply_enclosures(self.regulator.enclosure, self.estimator.enclosure)

    def __str__(self) -> str:
        names = (("regulator", self.regulator), ("estimator", self.estimator))
        return "\n".join(f"{name}: {text_of(f.polynomial, f.enclosure)}" for name, f in names)

    def _repr_latex_(self) -> str:
        return displayed(rf"\tilde D = {latex_of(self.polynomial, self.enclosure)}")


@refusing
def lqg_poles(plant: StandardProblem, *, digits: int = 30) -> LQGPoles:
    r"""Find the closed-loop poles of LQG without solving a Riccati equation.

    Parameters
    ----------
    plant : StandardProblem
        Rational, any number of signals, cross terms allowed; its variable s, z or q says the time
        domain. :math:`R_2 = E_2^TE_2` and :math:`V_2 = D_2D_2^T` may be singular or zero in
        discrete time and are nonsingular in continuous time.
    digits : int
        Where a factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.

    Returns
    -------
    LQGPoles

    Raises
    ------
    NotControllableError, NotObservableError
        If a hidden mode is not stable.
    UnitCircleError
        If a zero of :func:`regulator_spectrum` is on the unit circle.
    NoSolutionError
        If a spectrum is zero, for instance with :math:`N_{zu} = 0` or with more inputs u than
        outputs z and :math:`R_2 = 0`; in continuous time if it vanishes on the imaginary axis, or
        :math:`R_2` or :math:`V_2` is singular, so that a gain is infinite.
    InputError
        If an entry is symbolic, or the plant is not written in s, z or q.

    Notes
    -----
    Stable hidden modes stay closed-loop poles. Source: (A.4)-(A.12) and their counterpart in
    continuous time, with the assumptions ii) and iv) replaced by what :math:`R_2 = 0` needs: no
    zero on the unit circle.

    Examples
    --------
    >>> from compensator_theory import StandardProblem, lqg_poles
    >>> plant = StandardProblem(A=[[2, 1], [0, "1/2"]], B=[[1, 0], [0, 1]], C=[[1, 0], [0, 1]],
    ...     D_1=[[1, 0], [0, 1]], D_0=None, D_2=None, E_1=[[1, 0], [0, 1]], E_2=None, E_0=None)
    >>> lqg_poles(plant).polynomial
    Poly(q**4, q, domain='QQ')
    >>> plant = StandardProblem(A=[[1, 0], [0, 2]], B=[[1, 0], [0, 1]], C=[[1, 0], [0, 1]],
    ...     D_1=[[0, 0, 0], [0, 0, 0]], D_0=None, D_2=[[1, 0, 0], [0, 1, 0]],
    ...     E_1=[[0, 0], [0, 0]], E_2=[[1, 0], [0, 1]], E_0=None, variable="s")
    >>> print(lqg_poles(plant))
    regulator: s**2 + 3*s + 2
    estimator: s**2 + 3*s + 2
    """
    regulator, estimator = regulator_and_estimator(plant)
    s = plant.variable
    time = time_of(s, "LQG")
    require_stable_hidden_modes(plant, time)
    factors = []
    for name, weight, (A, B, E_1, E_2) in (
        ("from u to z", "u", regulator),
        ("from w to y", "the sensor noise", estimator),
    ):
        spectrum = regulator_spectrum(A, B, E_1=E_1, E_2=E_2, time=time, variable=s)
        if time == "continuous" and (spectrum.is_zero or spectrum.degree() < 2 * plant.n):
            raise NoSolutionError(
                f"a combination of {weight} has zero weight, so the optimal gain is infinite; "
                "weight every combination, or see regulator_locus for the limits of the poles"
            )
        if spectrum.is_zero:
            raise NoSolutionError(
                f"the transfer matrix {name} has too small a rank: the weights do not determine "
                "the controller. Weight u (or add sensor noise), or drop a signal"
            )
        try:
            factors.append(factor_spectrum(spectrum, plant.n, time, digits))
        except (UnitCircleError, NoSolutionError) as error:
            boundary = "unit circle" if time == "discrete" else "imaginary axis"
            raise type(error)(
                f"the transfer matrix {name} has a zero on the {boundary}, so that no LQG "
                f"controller is stabilising: {error}"
            ) from error
    return LQGPoles(*factors)


def require_stable_hidden_modes(plant: StandardProblem, time: Time) -> None:
    """Refuse an uncontrollable or unobservable mode that is not stable."""
    region = "inside the unit circle" if time == "discrete" else "left of the imaginary axis"
    for error, matrices, kind in (
        (NotControllableError, (plant.A, plant.B), "uncontrollable from u"),
        (NotObservableError, (plant.A.T, plant.C.T), "unobservable from y"),
    ):
        hidden = uncontrollable_polynomial(*matrices, variable=plant.variable)
        count = count_roots(hidden, time=time)
        if count.boundary or count.unstable:
            raise error(
                f"the mode(s) {format_polynomial(hidden)} are {kind} and not all {region}, so that "
                "no controller is stabilising; remove them from the plant"
            )
