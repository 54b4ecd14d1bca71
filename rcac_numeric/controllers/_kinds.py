"""The controller structures of the text, each as a table of taps."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import integer, matrix
from rcac_numeric.controllers._structure import (
    LONGEST_DELAY,
    DerivedSignal,
    Structure,
    Tap,
    difference,
    integral,
)


def iir(n_c: int, l_u: int = 1, l_y: int = 1, k_c: int = 1) -> Structure:
    """The IIR structure (2.28)-(2.33) of order `n_c`.

    Parameters
    ----------
    n_c : int
        Order, at least 1: that of a plant with its dead time places every pole, an integrator for
        the disturbance takes one more, and what is beyond costs robustness.
    l_u, l_y : int
        Number of control inputs and of measurements.
    k_c : int
        First lag of y: 0 for an exactly proper controller, up to n_c.

    Examples
    --------
    >>> from rcac_numeric import iir
    >>> iir(n_c=3, l_u=2, l_y=1).l_theta  # l_u^2 n_c + l_u l_y (n_c + 1 - k_c)
    18
    """
    order, inputs, outputs, first = _sizes(n_c, l_u, l_y, k_c)
    taps = (*_past("u", inputs, 1, order), *_past("y", outputs, first, order))
    return Structure(taps, inputs, outputs, order, "IIR")


def fir(n_c: int, l_u: int = 1, l_y: int = 1, k_c: int = 1) -> Structure:
    """The FIR structure (2.34)-(2.35): every pole of the controller is at zero.

    Examples
    --------
    >>> from rcac_numeric import fir
    >>> fir(n_c=5).l_theta
    5
    """
    order, inputs, outputs, first = _sizes(n_c, l_u, l_y, k_c)
    return Structure(_past("y", outputs, first, order), inputs, outputs, order, "FIR")


def quasi_fir(n_c: int, free_poles: int = 2, l_u: int = 1, l_y: int = 1, k_c: int = 1) -> Structure:
    """The quasi-FIR structure (6.1): `free_poles` lags of u, the other poles at zero.

    (6.1) has two free poles. `reflect_poles` of `ControllerSettings` keeps them inside the unit
    circle (section 6.2.2).

    Examples
    --------
    >>> from rcac_numeric import quasi_fir
    >>> quasi_fir(n_c=50).l_theta
    52
    """
    order, inputs, outputs, first = _sizes(n_c, l_u, l_y, k_c)
    free = integer(free_poles, "free_poles", at_most=order)
    taps = (*_past("u", inputs, 1, free), *_past("y", outputs, first, order))
    return Structure(taps, inputs, outputs, order, "quasi-FIR")


def pid(
    terms: str = "PID",
    l_u: int = 1,
    l_y: int = 1,
    *,
    k_c: int = 1,
    integral_limit: float = math.inf,
) -> Structure:
    """The strictly proper PID structure (2.58)-(2.62), or some of its terms.

    u(k) = K_P y(k-1) + K_I gamma(k-1) + K_D [y(k-1) - y(k-2)], gamma(k) = gamma(k-1) + y(k-1)

    theta holds the gains in the order of `terms`, each an l_u x l_y matrix stacked by columns.

    Parameters
    ----------
    terms : str
        Any of "P", "I" and "D" in any order, each once.
    k_c : {1, 0}
        0: every term is one step newer, K_P y(k) + K_I gamma(k) + K_D [y(k) - y(k-1)], as in most
        published implementations; needs D_0 = 0.
    integral_limit : float
        The integrator state is held within +-integral_limit.

    Examples
    --------
    >>> from rcac_numeric import pid
    >>> pid().compensator([0.2, 0.1, 0.05]).poles().real  # the integrator, and two zeros
    array([1., 0., 0.])
    >>> pid("PI").l_theta
    2
    """
    if (
        not isinstance(terms, str)
        or not terms
        or set(terms) - set("PID")
        or len(set(terms)) < len(terms)
    ):
        raise InputError(
            f"terms = {terms!r}: name each of the terms P, I and D at most once, such as 'PI'."
        )
    outputs = integer(l_y, "l_y", at_least=1)
    lag = integer(k_c, "k_c", at_most=1)
    derived: list[DerivedSignal] = []
    taps: list[Tap] = []
    for term in terms:
        if term == "P":
            taps += [Tap("y", i, lag) for i in range(outputs)]
            continue
        # gamma of (2.62) is one step behind the running sum, so K_I reads it two steps back.
        delay = lag + 1 if term == "I" else lag
        taps += [Tap("derived", len(derived) + i, delay) for i in range(outputs)]
        rows = [list(row) for row in np.eye(outputs)]
        derived += [
            integral(row, integral_limit) if term == "I" else difference(row) for row in rows
        ]
    return Structure(taps, integer(l_u, "l_u", at_least=1), outputs, 2, terms, derived=derived)


def fir_integrator(
    n_c: int,
    F: ArrayLike | None = None,
    l_u: int = 1,
    l_y: int = 1,
    k_c: int = 1,
    *,
    integral_limit: float = math.inf,
) -> Structure:
    """An FIR controller with an integrator in parallel, (6.4)-(6.5).

    u(k) = sum Q_i y(k-i) + K_1 gamma(k), gamma(k) = gamma(k-1) + F y(k)

    As printed, gamma(k) contains y(k), so the controller is exactly proper and needs D_0 = 0.

    Parameters
    ----------
    F : array, shape (l_gamma, l_y), optional
        Selects the components of y to integrate; all of them by default.
    integral_limit : float
        The integrator states are held within +-integral_limit.

    Examples
    --------
    >>> from rcac_numeric import fir_integrator
    >>> fir_integrator(n_c=10).l_theta
    11
    """
    order, inputs, outputs, first = _sizes(n_c, l_u, l_y, k_c)
    rows = np.eye(outputs) if F is None else matrix(F, "F", (None, outputs))
    if not len(rows):
        raise InputError("F has no rows, so the integrator has no input; use fir(...).")
    taps = (
        *_past("y", outputs, first, order),
        *(Tap("derived", i, 0) for i in range(len(rows))),
    )
    derived = [integral(list(row), integral_limit) for row in rows]
    return Structure(taps, inputs, outputs, order, "FIR + integrator", derived=derived)


def feedforward(
    n_c: int,
    l_u: int = 1,
    l_y: int = 1,
    l_r: int = 1,
    *,
    k_c: int = 1,
    feedback: str = "iir",
    first_r: int | None = None,
) -> Structure:
    """Feedback and feedforward: the controller reads the measurement y and the command r.

    With `feedback` = "iir" this is the centralised architecture of figure 2.15: one denominator
    for both paths. With "none" it is the feedforward half of figure 2.16, which runs beside a
    feedback controller of its own (`Decentralized`).

    Parameters
    ----------
    feedback : {"iir", "fir", "none"}
        "iir" reads past u, y and r; "fir" past y and r; "none" past u and r.
    first_r : int, optional
        First lag of r; `k_c` by default, 0 is allowed.

    Examples
    --------
    >>> from rcac_numeric import feedforward
    >>> feedforward(n_c=8).l_theta
    24
    """
    order, inputs, outputs, first = _sizes(n_c, l_u, l_y, k_c)
    commands = integer(l_r, "l_r", at_least=1)
    if feedback not in ("iir", "fir", "none"):
        raise InputError(f"feedback = {feedback!r} is not known; choose one of iir, fir, none.")
    start = first if first_r is None else integer(first_r, "first_r", at_most=order)
    taps = (
        *(() if feedback == "fir" else _past("u", inputs, 1, order)),
        *(() if feedback == "none" else _past("y", outputs, first, order)),
        *_past("r", commands, start, order),
    )
    return Structure(taps, inputs, outputs, order, "feedforward", l_r=commands)


def _past(signal: str, width: int, first: int, last: int) -> tuple[Tap, ...]:
    return tuple(Tap(signal, i, lag) for lag in range(first, last + 1) for i in range(width))


def _sizes(n_c: int, l_u: int, l_y: int, k_c: int) -> tuple[int, int, int, int]:
    order = integer(n_c, "n_c", at_least=1, at_most=LONGEST_DELAY)
    first = integer(k_c, "k_c")
    if first > order:
        raise InputError(f"k_c = {first} exceeds n_c = {order}: the controller would not read y.")
    return order, integer(l_u, "l_u", at_least=1), integer(l_y, "l_y", at_least=1), first
