"""The target model that a record supports, or the reason why it supports none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory._few_lines import in_few_lines
from compensator_theory._truth import Truth
from compensator_theory.errors import InputError
from rcac_numeric.arrays._values import Result
from rcac_numeric.identification._mu_markov import (
    IdentifiedMarkovParameters,
    identify_markov_parameters,
)
from rcac_numeric.identification._zeros import (
    IdentifiedZeros,
    identified_zeros,
    plain_number,
)
from rcac_numeric.targets._model import TargetModel
from rcac_numeric.targets._modelling import ModellingInformation
from rcac_numeric.targets._pole_placement import fir_target


@dataclass(frozen=True)
class DataFact(Truth):
    """A property of a plant from data, with its probability.

    Attributes
    ----------
    name : {"relative degree", "sign", "NMP zeros"}
    value : str
    probability : float
        That it is so, from the covariance of the Markov parameters.
    level : float
        The probability from which on it counts as sure.
    why : str
        What the probability rests on.
    """

    name: str
    value: str
    probability: float
    level: float
    why: str

    @property
    def is_sure(self) -> bool:
        """Whether the data support it."""
        return self.probability >= self.level

    def __str__(self) -> str:
        word = "sure" if self.is_sure else "NOT sure"
        return f"{self.name} {self.value}: {word}, {100 * self.probability:.3g} % ({self.why})"


@dataclass(frozen=True, eq=False)
class DataTarget(Result):
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
    level : float
        Of confidence.
    """

    _REST: ClassVar[str] = ".facts and .zeros have all"

    target: TargetModel
    information: ModellingInformation
    zeros: IdentifiedZeros
    markov: IdentifiedMarkovParameters
    level: float = 0.95

    @property
    def facts(self) -> tuple[DataFact, ...]:
        """Relative degree, leading sign and NMP zeros, each with its probability.

        The first significant Markov parameter is never too early and often too late: a plant of
        slow lags hardly answers in its first step. What can be told from data is how small the
        parameter before it is. n lags without zeros, sampled fast, begin with 1 : 2^n - 1, and
        slower sampling makes the first one larger; so the relative degree is d with the
        probability that

            abs(H_(d-1)) < abs(H_d)/(2^n - 1),  n = order.

        Sign and zeros are those of the plant if d is.
        """
        d, H, error = self.zeros.d_zu, self.markov.H.ravel(), self.markov.standard_error.ravel()
        from scipy.stats import t as student  # half a second of import time

        limit, nu = abs(H[d]) / (2.0**self.zeros.order - 1), self.markov.freedom
        if d:
            low, high = ((bound - H[d - 1]) / error[d - 1] for bound in (-limit, limit))
            early = float(student.cdf(high, nu) - student.cdf(low, nu))
            why = f"H_{d - 1} is {H[d - 1]:.2g} +- {error[d - 1]:.2g}, and would be {limit:.2g}"
        else:
            early, why = 1.0, "no parameter is before H_0"
        sign = float(student.cdf(abs(H[d]) / error[d], nu))
        gaps = np.abs(np.abs(self.zeros.zeros) - 1)
        sides = float(np.prod(student.cdf(gaps / self.zeros.modulus_error, self.zeros.freedom)))
        outside = len(self.information.nmp_zeros)
        leading = "+" if H[d] > 0 else "-"
        return (
            DataFact("relative degree", str(d), early, self.level, why),
            DataFact("sign", leading, early * sign, self.level,
                     f"of H_{d}, {H[d]:.2g} +- {error[d]:.2g}, if the relative degree is right"),
            DataFact("NMP zeros", str(outside), early * sides, self.level,
                     f"of {len(gaps)} zeros, if the relative degree is right"),
        )  # fmt: skip

    @in_few_lines
    def __str__(self) -> str:
        return "\n".join([str(self.information), *map(str, self.facts), str(self.zeros)])


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
    What cannot be refused is a relative degree that is too large, with the sign and the zeros that
    go with it: `facts` says how sure each is, and the report marks what is not. A zero on the wrong
    side costs stability, so nothing is guessed: with a sampling zero near -1,
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
    >>> [(fact.name, fact.value, fact.is_sure) for fact in found.facts]
    [('relative degree', '1', True), ('sign', '+', True), ('NMP zeros', '1', True)]
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
                f"{named}: the data do not decide whether it is inside the unit circle at "
                f"the level {level:g}. Keep the target; record more data, or a stronger input."
            )
        if phase == "nonminimum phase" and error > largest_error * abs(zero):
            raise InputError(
                f"{named}, more than {largest_error:g} of it. Keep the target; record more data, "
                "or a stronger input."
            )
    outside = [plain_number(zero) for zero, _, phase in rows if phase == "nonminimum phase"]
    known = ModellingInformation(zeros.d_zu, float(np.squeeze(zeros.leading)), outside)
    return DataTarget(fir_target(known), known, zeros, markov, level)
