"""The target model that a record of data can carry, or the reason why it carries none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays.values import Value
from rcac_numeric.identification.mu_markov import (
    IdentifiedMarkovParameters,
    identify_markov_parameters,
)
from rcac_numeric.identification.zeros import (
    IdentifiedZeros,
    identified_zeros,
    plain_number,
)
from rcac_numeric.targets.model import TargetModel
from rcac_numeric.targets.modelling import ModellingInformation
from rcac_numeric.targets.pole_placement import fir_target


@dataclass(frozen=True, eq=False)
class DataTarget(Value):
    """A target model made from data, with its evidence.

    Attributes
    ----------
    target : TargetModel
        (2.49) or (2.50), with the identified NMP zeros.
    information : ModellingInformation
        Relative degree, leading coefficient and NMP zeros that it was made of.
    zeros : IdentifiedZeros
        All zeros with their uncertainty.
    markov : IdentifiedMarkovParameters
    """

    target: TargetModel
    information: ModellingInformation
    zeros: IdentifiedZeros
    markov: IdentifiedMarkovParameters

    def __str__(self) -> str:
        return f"{self.information}\n{self.zeros}"


def target_from_data(
    u: ArrayLike,
    z: ArrayLike,
    mu: int,
    n_mod: int,
    *,
    order: int,
    level: float = 0.95,
    largest_error: float = 0.05,
) -> DataTarget:
    """The FIR target model with the NMP zeros that a window of data shows, sections 3.3 and 3.6.

    G_f(q) = H_d_zu N_zu,u(q) / q^(d_zu + deg N_zu,u)

    Parameters
    ----------
    u, z : arrays of shape (steps,) or (steps, 1)
        Scalar control and performance; for the servo problem, z = r - y, that is -y less its mean.
    mu, n_mod : int
        As for `identify_markov_parameters`.
    order : int
        Number of states.
    level : float
        Of confidence, at which each zero must lie inside or outside the unit circle.
    largest_error : float
        The largest standard error of the modulus of an NMP zero, relative to the modulus.

    Raises
    ------
    InputError
        If the data cannot carry the target: too few, not exciting, made by feedback alone, the
        control's effect insignificant, a zero undecided, or an NMP zero known too badly. Keep the
        target that you have, then, and record more data or perturb the input more.

    Notes
    -----
    A zero on the wrong side costs stability, so nothing is guessed: with a sampling zero near -1,
    as the aircraft has, only little noise lets a window decide. A window that holds a change of
    the plant is not recognised as such; compare residuals of windows. One window, offline: when to
    ask, and how to change the target of a running controller, is not decided here.

    Examples
    --------
    >>> import numpy as np, scipy.signal
    >>> from rcac_numeric import target_from_data
    >>> rng = np.random.default_rng(0)
    >>> u = rng.standard_normal(1500)
    >>> z = scipy.signal.lfilter([0, 2, -3], [1, -0.5, 0.2], u) + 0.05 * rng.standard_normal(1500)
    >>> found = target_from_data(u, z, mu=10, n_mod=2, order=2)
    >>> found.target.numerator.ravel().round(1)
    array([ 0.,  2., -3.])
    """
    markov = identify_markov_parameters(u, z, mu, n_mod)
    if markov.H.shape[1:] != (1, 1):
        raise InputError(
            f"the map from u to z is {markov.H.shape[1]} x {markov.H.shape[2]}; this target model "
            "is for scalar u and z. Use markov_target for a matrix."
        )
    zeros = identified_zeros(markov, order=order)
    rows = list(
        zip(zeros.zeros.tolist(), zeros.modulus_error.tolist(), zeros.phases(level), strict=True)
    )
    for zero, error, phase in rows:
        named = f"the zero {plain_number(zero):.6g} has the modulus {abs(zero):.6g} +- {error:.2g}"
        if phase == "undecided":
            raise InputError(
                f"{named}, so that the data do not say whether it is inside the unit circle at "
                f"the level {level:g}. Keep the target; record more data, or a stronger input."
            )
        if phase == "nonminimum phase" and error > largest_error * abs(zero):
            raise InputError(
                f"{named}, more than {largest_error:g} of it. Keep the target; record more data, "
                "or a stronger input."
            )
    outside = [plain_number(zero) for zero, _, phase in rows if phase == "nonminimum phase"]
    known = ModellingInformation(zeros.d_zu, float(np.squeeze(zeros.leading)), outside)
    return DataTarget(fir_target(known), known, zeros, markov)
