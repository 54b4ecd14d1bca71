"""LQG closed-loop poles of plants with any number of signals, by an exact determinant."""

from collections.abc import Callable
from dataclasses import dataclass

from sympy import Poly

from compensator_theory.errors import (
    InputError,
    NoSolutionError,
    NotControllableError,
    NotObservableError,
    UnitCircleError,
)
from compensator_theory.latex import displayed
from compensator_theory.lqg.regulator_spectra import regulator_spectrum
from compensator_theory.lqg.separation import enclosed_product, product_of_factors
from compensator_theory.polynomials.budget import shown
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import require_discrete
from compensator_theory.roots.counts import RootCount
from compensator_theory.roots.enclosures import PolynomialEnclosure, latex_of, text_of
from compensator_theory.roots.schur_cohn import count_unit_disk_roots
from compensator_theory.roots.spectral_factors import SpectralFactor, factor_palindrome
from compensator_theory.systems.controllability import uncontrollable_polynomial
from compensator_theory.systems.standard_problems import StandardProblem


@dataclass(frozen=True)
class LQGPoles(ExactValue):
    r"""Where LQG puts the closed-loop poles.

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
        return product_of_factors(self.regulator, self.estimator)

    @property
    def enclosure(self) -> PolynomialEnclosure:
        """The closed-loop polynomial, certified."""
        return enclosed_product(self.regulator, self.estimator)

    def __str__(self) -> str:
        names = (("regulator", self.regulator), ("estimator", self.estimator))
        return "\n".join(f"{name}: {text_of(f.polynomial, f.enclosure)}" for name, f in names)

    def _repr_latex_(self) -> str:
        return displayed(rf"\tilde D = {latex_of(self.polynomial, self.enclosure)}")


def lqg_poles(plant: StandardProblem, *, digits: int = 30) -> LQGPoles:
    r"""Find the closed-loop poles of LQG without solving a Riccati equation.

    Parameters
    ----------
    plant : StandardProblem
        Rational, any number of signals; :math:`R_2 = E_2^TE_2` and :math:`V_2 = D_2D_2^T` may be
        singular or zero.
    digits : int
        Where a factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.

    Returns
    -------
    LQGPoles

    Raises
    ------
    UnitCircleError
        If a zero of :func:`regulator_spectrum` is on the unit circle (an uncontrollable or
        unobservable mode there included).
    NoSolutionError
        If a spectrum is zero, for instance with :math:`N_{zu} = 0` or with more inputs u than
        outputs z and :math:`R_2 = 0`.
    InputError
        If an entry is symbolic, or the plant is not written in z or q.

    Notes
    -----
    Hidden modes inside the unit circle stay closed-loop poles; others are refused. Source:
    (A.4)-(A.12), with the assumptions ii) and iv) replaced by what :math:`R_2 = 0` needs: no zero
    on the unit circle.

    Examples
    --------
    >>> from compensator_theory import StandardProblem, lqg_poles
    >>> plant = StandardProblem(A=[[2, 1], [0, "1/2"]], B=[[1, 0], [0, 1]], C=[[1, 0], [0, 1]],
    ...     D_1=[[1, 0], [0, 1]], D_0=None, D_2=None, E_1=[[1, 0], [0, 1]], E_2=None, E_0=None)
    >>> lqg_poles(plant).polynomial
    Poly(q**4, q, domain='QQ')
    """
    if not isinstance(plant, StandardProblem):
        raise InputError(f"{shown(plant)} is not a StandardProblem; see standard_problem()")
    q = plant.variable
    require_discrete(q, "LQG")
    require_stable_hidden_modes(plant, count_unit_disk_roots, "inside the unit circle")
    regulator = regulator_spectrum(plant.A, plant.B, plant.E_1, plant.E_2, q)
    estimator = regulator_spectrum(plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T, q)
    factors = []
    for name, spectrum in (("from u to z", regulator), ("from w to y", estimator)):
        try:
            factors.append(factor_palindrome(spectrum, plant.n, digits))
        except UnitCircleError as error:
            raise UnitCircleError(
                f"the transfer matrix {name} has a zero on the unit circle, so that no LQG "
                f"controller is stabilising: {error}"
            ) from error
        except NoSolutionError as error:
            raise NoSolutionError(
                f"the transfer matrix {name} has too small a rank: the weights do not determine "
                "the controller. Weight u (or add sensor noise), or drop a signal"
            ) from error
    return LQGPoles(*factors)


def require_stable_hidden_modes(
    plant: StandardProblem, counted: Callable[[Poly], RootCount], region: str
) -> None:
    """Refuse a mode that no gain moves and that is not in the region of stability.

    Examples
    --------
    >>> from compensator_theory import standard_problem
    >>> from compensator_theory.lqg.poles import require_stable_hidden_modes
    >>> from compensator_theory.roots.schur_cohn import count_unit_disk_roots
    >>> plant = standard_problem("1/(q - 2)")
    >>> require_stable_hidden_modes(plant, count_unit_disk_roots, "inside the unit circle")
    """
    for error, matrices, what in (
        (NotControllableError, (plant.A, plant.B), "uncontrollable from u"),
        (NotObservableError, (plant.A.T, plant.C.T), "unobservable from y"),
    ):
        hidden = uncontrollable_polynomial(*matrices, plant.variable)
        count = counted(hidden)
        if count.boundary or count.unstable:
            raise error(
                f"the mode(s) {format_polynomial(hidden)} are {what} and not all {region}, so that "
                "no controller is stabilising; remove them from the plant"
            )
