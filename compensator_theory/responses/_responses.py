"""Responses of exact systems from rest: to a step, an impulse, or any rational transform."""

from __future__ import annotations

from dataclasses import replace

import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory.polynomials._carrying import carried_by, carrying
from compensator_theory.responses._time_responses import TimeResponse, inverse_transform
from compensator_theory.systems._dead_times import DelayedLike, transfer_function
from compensator_theory.systems._delayed_transfer_functions import DelayedTransferFunction
from compensator_theory.systems._transfer_functions import TransferFunction


@carried_by("all")
def step_response(G: DelayedLike, variable: str | Symbol | None = None) -> TimeResponse:
    r"""Return the response to a unit step from rest, in closed form.

    .. math:: y(t) = \mathcal L^{-1}\Big\{G(s)\,\frac 1s\Big\}, \qquad
              y(k) = \mathcal Z^{-1}\Big\{G(z)\,\frac{z}{z - 1}\Big\}

    Parameters
    ----------
    G : transfer function
        In s, where it may have a dead time, or proper in z or q; anything
        :func:`transfer_function` reads.
    variable : str or Symbol, optional
        Default: evident.

    Returns
    -------
    TimeResponse
        Exponentials, sines and polynomials of t or k. Poles of an irreducible factor of degree
        three or more stay a sum over its roots. `overshoot()`, `settling_time()` and `rise_time()`
        are methods.

    Raises
    ------
    ImproperError
        If G is improper in z or q.
    InputError
        If G cannot be read, or its variable shows no time domain.

    Notes
    -----
    From rest: a mode that numerator and denominator share does not appear. With symbols the closed
    form holds where no expression of `exceptional` is 0; a square root in it may be imaginary, then
    its sine and cosine are hyperbolic. python-control's function of this name returns samples.

    Examples
    --------
    >>> from compensator_theory import step_response
    >>> print(step_response("w**2/(s**2 + w**2)"))
    y(t) = 1 - cos(t*w)
    >>> print(step_response("1/(z - 1/2)"))
    y(k) = 2 - 2/2**k
    >>> y = step_response("2*exp(-3*s)/(10*s + 1)")
    >>> print(y)
    y(t) = (2 - 2*exp(3/10 - t/10))*Heaviside(t - 3)
    >>> y(2), y(13), y.settling_time()
    (0, 2 - 2*exp(-1), 42.12023005428 ± 2.9e-11)
    """
    G = transfer_function(G, variable)
    unit = Poly(G.variable if G.time == "discrete" else 1, G.variable, domain="QQ")
    origin = Poly(G.variable, G.variable, domain="QQ") - (1 if G.time == "discrete" else 0)
    return _response(G * TransferFunction(unit, origin))


@carried_by("all")
def impulse_response(G: DelayedLike, variable: str | Symbol | None = None) -> TimeResponse:
    r"""Return the response to a unit impulse from rest: the inverse transform of G.

    .. math:: g(t) = \mathcal L^{-1} G(s), \qquad g(k) = \mathcal Z^{-1} G(z)

    Parameters
    ----------
    G : transfer function
        In s, where it may have a dead time, or proper in z or q; anything
        :func:`transfer_function` reads.
    variable : str or Symbol, optional
        Default: evident.

    Raises
    ------
    ImproperError, InputError
        As :func:`step_response`.

    Examples
    --------
    >>> from compensator_theory import impulse_response
    >>> print(impulse_response("(s + 2)/(s + 1)**2"))
    y(t) = t*exp(-t) + exp(-t)
    >>> impulse_response("1/(z**2 - z - 1)")(11)  # Fibonacci's number
    55
    """
    return _response(transfer_function(G, variable))


@carried_by("all")
def time_response(
    G: DelayedLike, U: DelayedLike, *, variable: str | Symbol | None = None
) -> TimeResponse:
    r"""Return the response from rest to an input of which the transform is rational.

    .. math:: y(t) = \mathcal L^{-1}\{G(s)\,U(s)\}, \qquad y(k) = \mathcal Z^{-1}\{G(z)\,U(z)\}

    Parameters
    ----------
    G : transfer function
        Anything :func:`transfer_function` reads.
    U : transfer function
        The transform of the input: 1/s**2 for a ramp, w/(s**2 + w**2) for sin(w t),
        z/(z - 1)**2 for the ramp k.
    variable : str or Symbol, optional
        Default: evident.

    Raises
    ------
    ImproperError
        If G U is improper in z or q.
    InputError
        If one of the two cannot be read, or they are in different variables.

    Examples
    --------
    >>> from compensator_theory import time_response
    >>> print(time_response("1/(s + 1)", "1/s**2"))
    y(t) = t - 1 + exp(-t)
    >>> y = time_response("1/(s + a)", "w/(s**2 + w**2)")
    >>> y.exceptional
    (w, a**2 + w**2)
    """
    G = transfer_function(G, variable)
    return _response(G * transfer_function(U, G.variable))


def _response(Y: TransferFunction | DelayedTransferFunction) -> TimeResponse:
    """Return the inverse transform, shifted by the dead time."""
    if isinstance(Y, DelayedTransferFunction):
        return _inverse(Y.rational, Y.delay)
    return _inverse(Y, sympy.Integer(0))


@carrying()
def _inverse(Y: TransferFunction, delay: Expr) -> TimeResponse:
    """Return the inverse transform of Y exp(-delay s)."""
    return replace(inverse_transform(Y), delay=delay)
