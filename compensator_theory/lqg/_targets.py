"""The target model of RCAC whose match is the closed loop of high-authority LQG."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Poly

from compensator_theory._latex import displayed, fraction, latex
from compensator_theory.errors import InputError, NoSolutionError, UnitCircleError
from compensator_theory.lqg._regulator_data import regulator_and_estimator
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import require_discrete
from compensator_theory.roots._enclosures import PolynomialEnclosure
from compensator_theory.roots._unit_circle import require_none_on_circle
from compensator_theory.roots._unit_circle_enclosures import (
    enclose_split_at_unit_circle,
    exact_enclosure,
    monic_reciprocal_enclosure,
    multiply_enclosures,
)
from compensator_theory.systems._standard_problems import StandardProblem
from compensator_theory.systems._transfer_functions import TransferFunction


@dataclass(frozen=True)
class HighAuthorityTarget(ExactValue):
    r"""The target model (4.24), corrected.

    .. math:: G_f = \frac{H_{d_{zu}}\, q^{m}\, N_{zu,u}}
                         {\bar N_{zu,u}\, N_{yw,s}\, \bar N_{yw,u}}, \qquad
              m = n - d_{zu} - d_{yw}

    where the bar is the monic polynomial with the reflected zeros.

    Attributes
    ----------
    H : sympy.Rational
        Leading coefficient :math:`H_{d_{zu}}` of :math:`G_{zu}`.
    d_zu, d_yw : int
        Relative degrees.
    transfer_function : TransferFunction or None
        :math:`G_f` if the numerators split over the rationals, else None.
    numerator, denominator : PolynomialEnclosure
        Of :math:`G_f`, certified; radii 0 if rational.

    Examples
    --------
    >>> from compensator_theory import high_authority_target, standard_problem
    >>> print(high_authority_target(standard_problem("(q - 2)/(q**2 - 1/4)")))
    G_f = (q - 2)/(q**2 - q + 1/4)
    """

    H: Expr
    d_zu: int
    d_yw: int
    transfer_function: TransferFunction | None
    numerator: PolynomialEnclosure
    denominator: PolynomialEnclosure

    def __str__(self) -> str:
        if self.transfer_function is not None:
            return f"G_f = {self.transfer_function}"
        return f"G_f = ({self.numerator})/({self.denominator})"

    def _repr_latex_(self) -> str:
        if self.transfer_function is not None:
            return displayed(f"G_f = {latex(self.transfer_function)}")
        return displayed(f"G_f = {fraction(self.numerator, self.denominator)}")


@refusing
def high_authority_target(plant: StandardProblem, *, digits: int = 30) -> HighAuthorityTarget:
    r"""Build the target model whose exact match is the closed loop of high-authority LQG.

    .. math:: G_f = \frac{N_{zu}\, q^{n}}{\tilde D_{HA}}

    Parameters
    ----------
    plant : StandardProblem
        Rational, with scalar signals.
    digits : int
        Where a numerator does not split over the rationals, every radius is at most
        :math:`10^{-\mathrm{digits}}`.

    Returns
    -------
    HighAuthorityTarget

    Raises
    ------
    UnitCircleError
        If :math:`N_{zu}` or :math:`N_{yw}` has a zero on the unit circle.
    NoSolutionError
        If :math:`N_{zu} = 0` or :math:`N_{yw} = 0`.
    InputError
        If a signal is not scalar, an entry is symbolic, or the plant is not written in z or q.

    Notes
    -----
    ``rcac_numeric.targets.high_authority_target`` makes a target model of it.

    Errata of (4.24): :math:`N_u(q^{-1})` is to be read as the monic polynomial
    :math:`q^{n_u}N_u(1/q)/N_u(0)`. Read literally it needs :math:`m = n_c - d_{zu} - d_{yw} -
    n_{zu,u} - n_{yw,u}` instead of the printed :math:`n_c - d_{zu} - d_{yu}`, and a division by
    :math:`N_{zu,u}(0)N_{yw,u}(0)`; otherwise the relative degree of :math:`G_f` is not
    :math:`d_{zu}` and its leading coefficient is not :math:`H_{d_{zu}}`. The model is for
    :math:`n_c = n`; a longer controller has :math:`\tilde D = q^{n_c-n}\tilde D_{HA}` and the
    same :math:`G_f`.

    Examples
    --------
    >>> from compensator_theory import high_authority_target, standard_problem
    >>> target = high_authority_target(standard_problem("3*(q**2 - 3*q + 1)/(q**3 - 1/8)"))
    >>> target.transfer_function, target.d_zu, target.H
    (None, 1, 3)
    """
    N_zu, N_yw = scalar_numerators(plant)
    d_zu, d_yw = plant.n - int(N_zu.degree()), plant.n - int(N_yw.degree())
    m = plant.n - d_zu - d_yw
    q = plant.variable
    powers = [exact_enclosure(canonical(Poly(q ** max(k, 0), q))) for k in (m, -m)]
    zu_u = enclose_split_at_unit_circle(N_zu, digits=digits)[1]
    yw_s, yw_u = enclose_split_at_unit_circle(N_yw, digits=digits)
    gain = exact_enclosure(canonical(Poly(N_zu.LC(), q)))
    numerator = multiply_enclosures(gain, powers[0], zu_u)
    denominator = multiply_enclosures(
        powers[1], monic_reciprocal_enclosure(zu_u), yw_s, monic_reciprocal_enclosure(yw_u)
    )
    exact = None
    if numerator.radius == 0 == denominator.radius:
        exact = TransferFunction(
            numerator.centre, denominator.centre, sample_time=plant.sample_time
        )
    return HighAuthorityTarget(N_zu.LC(), d_zu, d_yw, exact, numerator, denominator)


def scalar_numerators(plant: StandardProblem) -> tuple[Poly, Poly]:
    r"""Return :math:`N_{zu}` and :math:`N_{yw}` of a plant that high-authority LQG can handle."""
    regulator_and_estimator(plant)
    require_discrete(plant.variable, "high-authority LQG")
    sizes = (plant.l_u, plant.l_w, plant.l_y, plant.l_z)
    if sizes != (1, 1, 1, 1):
        raise InputError(
            "high-authority formulas are for scalar u, w, y and z, but the plant has "
            f"{sizes} of them; lqg_poles gives the poles for any number of signals"
        )
    numerators = []
    for channel, ends in (("zu", "u does not reach z"), ("yw", "w does not reach y")):
        numerator = plant.numerator(channel)
        if numerator.is_zero:
            raise NoSolutionError(f"N_{channel} = 0: {ends}, so high-authority LQG is undefined")
        symbols = numerator.free_symbols_in_domain | plant.A.free_symbols
        if symbols:
            raise InputError(f"substitute rational numbers for {sorted(map(str, symbols))} first")
        try:
            require_none_on_circle(numerator)
        except UnitCircleError as error:
            raise UnitCircleError(
                f"N_{channel} has a zero on the unit circle, so that no stabilising solution "
                f"exists: {error}"
            ) from error
        numerators.append(numerator)
    return numerators[0], numerators[1]
