"""Target models with prescribed poles, and the FIR ones, from modelling information."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from sympy import QQ, Poly, Symbol

import compensator_theory as exact
from compensator_theory.errors import InputError
from compensator_theory.polynomials._from_roots import polynomial_or_roots
from rcac_numeric.plants._linear import Plant
from rcac_numeric.targets._model import TargetModel, from_transfer_function
from rcac_numeric.targets._modelling import ModellingInformation, Number, modelling_information


def fir_target(information: ModellingInformation | Plant) -> TargetModel:
    """The FIR target model (2.49), or (2.50) where there are NMP zeros.

    G_f(q) = H N_zu,u(q) / q^(d_zu + deg N_zu,u)

    Parameters
    ----------
    information : ModellingInformation or Plant
        What is known of G_zu; of a plant it is read exactly.

    Raises
    ------
    InputError
        If the signals of a plant are not scalar, or its control does not act on z.

    Notes
    -----
    It requires a loop that is at rest within d_zu + deg N_zu,u steps, as fast as any can be: all
    poles of the plant are moved to 0. With a dead time, or poles that are lightly damped, that is
    seldom a good loop, whatever R_theta is: of 60 random plants one of ten R_theta from 1e-14 to
    1e4 H^2 made a good loop (stable, error at the end below twice that of a fixed controller, no
    peak of ten times) of 20 %, of 10 % of the lightly damped and 12 % of those with a dead time
    above 3 steps. `design` makes its target of a robust loop, for a plant or a log; `cold_start`,
    for modelling information alone, takes slower poles.

    Examples
    --------
    >>> from rcac_numeric import ModellingInformation, fir_target
    >>> fir_target(ModellingInformation(d_zu=1, H=2.0, nmp_zeros=(1.5,))).numerator.ravel()
    array([ 0.,  2., -3.])
    """
    return pole_placement_target(information, ())


def pole_placement_target(
    information: ModellingInformation | Plant, poles: Sequence[Number] | Poly | str
) -> TargetModel:
    """The pole-placement target model (4.38), or (4.39) where there are NMP zeros.

    G_f(q) = H q^(n_p - d_zu - deg N_zu,u) N_zu,u(q) / D_p(q)

    Parameters
    ----------
    information : ModellingInformation or Plant
        What is known of G_zu; of a plant it is read exactly. Where its NMP zeros are irrational and
        a conjugate of theirs is not NMP, G_f is in float64 alone and `exact` is None.
    poles : sequence of numbers, or the polynomial D_p itself
        The n_p poles to place; exact where they are given as strings or rationals.

    Raises
    ------
    InputError
        If D_p cannot be read, is zero or holds symbols, or a pole lies outside the unit circle.

    Examples
    --------
    >>> from rcac_numeric import ModellingInformation, pole_placement_target
    >>> target = pole_placement_target(ModellingInformation(1, 1.0), ["1/2", "-1/2"])
    >>> target.denominator.ravel()
    array([ 1.  ,  0.  , -0.25])
    """
    known = (
        information
        if isinstance(information, ModellingInformation)
        else modelling_information(information)
    )
    if not isinstance(poles, str | Poly | Sequence | np.ndarray):
        raise InputError(f"poles = {poles!r} must be a list of roots or the polynomial D_p.")
    D_p = polynomial_or_roots(poles, "q")
    if D_p.is_zero:
        raise InputError("the polynomial D_p of the poles is zero.")
    if D_p.free_symbols_in_domain:
        raise InputError(f"D_p = {D_p.as_expr()} must be a polynomial in q without other symbols.")
    D_p = D_p.monic()
    N_u = known.nmp_polynomial()
    q = Poly([1, 0], Symbol("q"), domain=QQ)
    surplus = D_p.degree() - known.d_zu - N_u.degree()
    numerator = N_u * exact.exact_number(known.H) * q ** max(surplus, 0)
    target = from_transfer_function(exact.TransferFunction(numerator, D_p * q ** max(-surplus, 0)))
    return target if known.is_exact else TargetModel(target.numerator, target.denominator)
