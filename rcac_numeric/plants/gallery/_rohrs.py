"""Rohrs's plant of Example 1.3, and its sampling zeros against the sampling period."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import ComplexArray
from rcac_numeric.arrays._validation import instance_of, items, number
from rcac_numeric.plants.gallery._continuous import ContinuousPlant
from rcac_numeric.plants.gallery._zeros import plant_zeros


def rohrs_plant() -> ContinuousPlant:
    """The plant T(s) of (1.7), a slow lag with unmodelled fast dynamics.

    T(s) = 2/(s + 1) 229/(s^2 + 30 s + 229)

    Notes
    -----
    Source: [24] of the text, C. E. Rohrs et al., Robustness of continuous-time adaptive control
    algorithms in the presence of unmodeled dynamics, IEEE Trans. Automatic Control 30 (1985);
    [38] applies RCAC to it. The states are the lag, then the fast pair in
    controller form.

    Errata: (1.7) prints (s - 15 + 2j)(s - 15 - 2j) for the fast poles, which would be unstable; the
    text says that the plant is asymptotically stable, and Rohrs's has them at -15 -+ 2j.

    Examples
    --------
    >>> from rcac_numeric.gallery import rohrs_plant
    >>> rohrs_plant().poles().round(6)
    array([-15.+2.j, -15.-2.j,  -1.+0.j])
    """
    return ContinuousPlant(
        A=[[-1, 0, 0], [0, 0, 1], [2, -229, -30]],
        B=[[1], [0], [0]],
        C=[[0, 229, 0]],
        inputs=["control"],
        outputs=["output"],
    )


def sampling_zeros(plant: ContinuousPlant, periods: Sequence[float]) -> list[ComplexArray]:
    """The zeros of a plant sampled with a zero-order hold, for each of several periods.

    Parameters
    ----------
    plant : ContinuousPlant
    periods : sequence of float
        In s.

    Returns
    -------
    list of complex arrays
        Largest modulus first. As the period goes to 0, relative degree - 1 of them go to the
        zeros of the Euler-Frobenius polynomial: -1 for relative degree 2, -3.732 and -0.268 for 3.

    Notes
    -----
    Source: K. J. Astrom, P. Hagander, J. Sternby, Zeros of sampled systems, Automatica 20 (1984).
    Where h is so short that the numerator, of the size h^(relative degree), is below the rounding
    of the sampled matrices, the zeros are those of the rounded matrices.

    Examples
    --------
    >>> from rcac_numeric.gallery import rohrs_plant, sampling_zeros
    >>> [abs(zeros).max().round(2).item() for zeros in sampling_zeros(rohrs_plant(), [0.01, 0.3])]
    [3.46, 0.6]
    """
    instance_of(plant, "plant", ContinuousPlant)
    return [plant_zeros(plant.sampled(h)) for h in items(periods, "periods")]


def critical_period(plant: ContinuousPlant, shortest: float, longest: float) -> float:
    """The sampling period, in s, at which the largest sampling zero has modulus 1.

    Parameters
    ----------
    plant : ContinuousPlant
    shortest, longest : float
        Periods between which the largest zero crosses the unit circle once.

    Raises
    ------
    InputError
        If the plant is nonminimum phase at both periods, or at neither.

    Notes
    -----
    By bisection until float64 has no period in between. Example 1.3 says that a zero of T is
    nonminimum phase for h below about 0.2 s; it is below 0.1991 s.

    Examples
    --------
    >>> from rcac_numeric.gallery import critical_period, rohrs_plant
    >>> round(critical_period(rohrs_plant(), 0.05, 0.5), 4)
    0.1991
    """
    low, high = number(shortest, "shortest"), number(longest, "longest")

    def outside(h: float) -> bool:
        return bool(np.abs(sampling_zeros(plant, [h])[0]).max(initial=0.0) >= 1)

    start = outside(low)
    if not low < high or start == outside(high):
        kind = "nonminimum phase" if start else "minimum phase"
        raise InputError(
            f"sampled at {low:g} s and at {high:g} s the plant is {kind}; give a shorter and a "
            "longer period between which a zero crosses the unit circle."
        )
    while (middle := low + (high - low) / 2) not in (low, high):
        low, high = (middle, high) if outside(middle) == start else (low, middle)
    return high
