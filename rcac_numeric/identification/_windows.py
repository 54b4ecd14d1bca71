"""Identification over windows that move through a record, section 3.6."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays._validation import integer
from rcac_numeric.arrays._values import Value
from rcac_numeric.identification._mu_markov import (
    IdentifiedMarkovParameters,
    identify_markov_parameters,
)
from rcac_numeric.identification._noise_models import NeweyWest
from rcac_numeric.identification._regressors import as_signal
from rcac_numeric.identification._zeros import IdentifiedZeros, identified_zeros


@dataclass(frozen=True, eq=False)
class IdentifiedWindow(Value):
    """The identification result of one window of a record.

    Attributes
    ----------
    start, stop : int
        The window holds the samples start, ..., stop - 1.
    markov : IdentifiedMarkovParameters, optional
        None where the window was refused.
    zeros : IdentifiedZeros, optional
        None where the window was refused, or `order` is None.
    refusal : str
        Why the window was refused; empty where it was not.
    """

    start: int
    stop: int
    markov: IdentifiedMarkovParameters | None
    zeros: IdentifiedZeros | None
    refusal: str = ""


def identify_windows(
    u: ArrayLike,
    y: ArrayLike,
    mu: int,
    n_mod: int,
    *,
    window: int = 70,
    step: int | None = None,
    order: int | None = None,
    noise: NeweyWest | None = NeweyWest(),  # noqa: B008 (frozen)
) -> tuple[IdentifiedWindow, ...]:
    """Markov parameters, and zeros, of each of the windows of a record.

    Parameters
    ----------
    u, y, mu, n_mod, noise
        As for `identify_markov_parameters`.
    window, step : int
        Samples in a window, and from one window to the next; the text has 70 and 70. By default
        windows do not overlap.
    order : int, optional
        Number of states for the zeros; without it no zeros are computed.

    Returns
    -------
    tuple of IdentifiedWindow
        A window whose data do not determine its model says so in `refusal`; the rest go on.

    Raises
    ------
    InputError
        If u and y are not equally long, the record is shorter than a window, or a setting is out
        of range.

    Notes
    -----
    A window that holds a change of the plant fits a plant that never was; its residual shows it.
    Four states need mu >= 10 at d_zu = 1: fewer parameters make a Hankel matrix below 4 x 4.

    Examples
    --------
    >>> import numpy as np, scipy.signal
    >>> from rcac_numeric.identification import identify_windows
    >>> u = np.random.default_rng(0).standard_normal(140)
    >>> u[70:] = 1.0
    >>> y = scipy.signal.lfilter([0, 1, -1.2], [1, -0.5, 0], u)
    >>> good, bad = identify_windows(u, y, mu=10, n_mod=2, order=2)
    >>> good.zeros.zeros.round(9), bad.refusal[:49]
    (array([1.2+0.j]), 'the input is persistently exciting of order 1 onl')
    """
    U, Y = as_signal(u, "u"), as_signal(y, "y")
    if len(U) != len(Y):
        raise InputError(f"u has {len(U)} steps and y has {len(Y)}; they must be equally long.")
    integer(mu, "mu", at_least=1), integer(n_mod, "n_mod")  # what no window could help
    length = integer(window, "window", at_least=1)
    stride = length if step is None else integer(step, "step", at_least=1)
    if len(U) < length:
        raise InputError(f"the record has {len(U)} samples, fewer than a window of {length}.")
    windows = []
    for start in range(0, len(U) - length + 1, stride):
        stop = start + length
        markov, zeros, refusal = None, None, ""
        try:
            markov = identify_markov_parameters(U[start:stop], Y[start:stop], mu, n_mod, noise)
            zeros = None if order is None else identified_zeros(markov, order=order)
        except CompensatorError as error:
            refusal = str(error)
        windows.append(IdentifiedWindow(start, stop, markov, zeros, refusal))
    return tuple(windows)
