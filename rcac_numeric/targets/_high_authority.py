"""The target model of high-authority LQG in float64."""

from __future__ import annotations

import compensator_theory as exact
from rcac_numeric.arrays._validation import rounded
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.targets._model import TargetModel, from_transfer_function


def high_authority_target(plant: Plant) -> TargetModel:
    """The high-authority LQG target model (4.24), corrected; scalar u, w, y and z.

    G_f(q) = H q^(n - d_zu - d_yw) N_zu,u / (mirror(N_zu,u) N_yw,s mirror(N_yw,u)), where mirror()
    is the monic polynomial with the zeros 1/z_i.

    A controller of order n whose intercalated transfer function (4.18) equals G_f closes the loop
    of high-authority LQG. With `compensator_theory.high_authority_target` every zero is split at
    the unit circle exactly; here each coefficient of the result is rounded once.

    Parameters
    ----------
    plant : Plant, or StandardProblem in discrete time
        With scalar signals; a servo problem, whose w is [r; d; v], must first be written with the
        one exogenous input that is stochastic.

    Raises
    ------
    UnitCircleError
        If G_zu or G_yw has a zero on the unit circle.
    NoSolutionError
        If G_zu = 0 or G_yw = 0.
    InputError
        If a signal is not scalar.

    Notes
    -----
    Errata of (4.24): the printed m = n_c - d_zu - d_yu must use d_yw, as (A.17) does, and
    N_u(q^{-1}) must be read as the monic polynomial with the reflected zeros. Printed literally,
    G_f of example 4.1 is noncausal with relative degree -4; with q^deg N_u(q^{-1}) that is not
    monic its gain is wrong by the product of -z_i. As built here G_f has the relative degree and
    the leading coefficient of G_zu. It serves n_c = n and, with n_c - n more poles at 0, any
    n_c >= n.

    Where a numerator does not split over the rationals, its factors are known to 30 digits and
    rounded from there; `exact` is then None.

    Examples
    --------
    >>> from rcac_numeric import standard_plant
    >>> from rcac_numeric.targets import high_authority_target
    >>> G_f = high_authority_target(standard_plant("(q - 2)/(q**2 - 1/4)"))
    >>> G_f.numerator.ravel(), G_f.denominator.ravel()
    (array([ 0.,  1., -2.]), array([ 1.  , -1.  ,  0.25]))
    """
    target = exact.high_authority_target(linear_plant(plant).problem)
    if target.transfer_function is not None:
        return from_transfer_function(target.transfer_function)
    numerator = [ball.centre for ball in target.numerator.coefficients]
    denominator = [ball.centre for ball in target.denominator.coefficients]
    padding = [0] * (len(denominator) - len(numerator))
    return TargetModel(
        rounded(padding + numerator, "the target model's numerator"),
        rounded(denominator, "the target model's denominator"),
    )
