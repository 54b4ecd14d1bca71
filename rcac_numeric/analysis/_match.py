"""The fit of RCAC, (4.14): intercalated transfer function and G_f, and the residual split."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_numeric.analysis._closed_loop import ClosedLoop, linear_states
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import instance_of, integer, signal_array
from rcac_numeric.arrays._values import Result
from rcac_numeric.controllers._compensator import Compensator, compensator_of
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.targets._model import TargetModel


@dataclass(frozen=True, eq=False)
class IntercalatedMatch(Result):
    """The distance between the intercalated transfer function and G_f over frequency.

    Attributes
    ----------
    omega : array
        Frequencies, rad/sample.
    reached, target : arrays, shape (len(omega), l_z, l_u)
        The intercalated transfer function and G_f.
    """

    omega: Array
    reached: ComplexArray
    target: ComplexArray

    @property
    def error(self) -> Array:
        """Distance at each frequency, relative to G_f there (Frobenius norms)."""
        norms = np.linalg.norm(self.target, axis=(1, 2))
        difference = np.linalg.norm(self.reached - self.target, axis=(1, 2))
        return np.asarray(difference / np.maximum(norms, np.finfo(float).tiny))

    @property
    def worst(self) -> float:
        """Largest relative distance."""
        return float(self.error.max())

    @property
    def median(self) -> float:
        """Median relative distance."""
        return float(np.median(self.error))

    def plot(self) -> figures.Figure:
        """Plot gain and phase of both, on one branch."""
        from rcac_numeric.plots._run import plot_match

        return plot_match(self)

    def __repr__(self) -> str:
        return f"IntercalatedMatch(worst={self.worst:.3g}, median={self.median:.3g})"


def intercalated_match(
    loop: ClosedLoop, target: TargetModel, points: int = 1000
) -> IntercalatedMatch:
    """Compare the intercalated transfer function (4.16) with G_f on a grid in (0, pi).

    Parameters
    ----------
    loop : ClosedLoop
    target : TargetModel
    points : int
        Number of frequencies, in the middles of as many equal parts of (0, pi).

    Examples
    --------
    >>> from rcac_numeric import (
    ...     ClosedLoop, Compensator, fir_target, intercalated_match, standard_plant)
    >>> plant = standard_plant("1/(q - 2)")
    >>> loop = ClosedLoop(plant, Compensator(past_u=[[[-2.0]]], past_y=[[[0.0]], [[-4.0]]]))
    >>> intercalated_match(loop, fir_target(plant)).worst < 1e-12  # both poles at zero: 1/q
    True
    """
    instance_of(loop, "loop", ClosedLoop)
    integer(points, "points", at_least=1)
    omega = (np.arange(points) + 0.5) * np.pi / points
    return IntercalatedMatch(
        omega, loop.intercalated_response(omega), target.frequency_response(omega)
    )


@dataclass(frozen=True, eq=False)
class ResidualSplit(Result):
    """z - G_f u~ = (G~zu~ - G_f) u~ + G~zw w, for one fixed theta* and recorded signals.

    Attributes
    ----------
    u_tilde : array, shape (steps, l_u)
        The virtual perturbation u - Phi theta* of (4.4).
    residual : array, shape (steps, l_z)
        The retrospective performance z - G_f u_tilde of (4.6).
    matching_error, disturbance_response : arrays, shape (steps, l_z)
        (G~zu~ - G_f) u_tilde and G~zw w, computed from the loop closed with theta*.
    """

    u_tilde: Array
    residual: Array
    matching_error: Array
    disturbance_response: Array

    @property
    def parts(self) -> dict[str, Array]:
        """Return the residual and its two parts, by name."""
        return {
            "residual": self.residual,
            "matching error": self.matching_error,
            "disturbance response": self.disturbance_response,
        }

    @property
    def identity_error(self) -> float:
        """Largest difference between the residual and the sum of its parts, relative.

        By (4.14) it is zero from rest, up to rounding.
        """
        parts = self.matching_error + self.disturbance_response
        size = max(np.abs(v).max(initial=0.0) for v in (self.residual, self.matching_error, parts))
        return float(np.abs(self.residual - parts).max(initial=0.0) / size) if size else 0.0

    def power(self, start: int = 0) -> dict[str, float]:
        """Return the mean square of each signal from step `start` on."""
        if start >= len(self.residual):
            return dict.fromkeys(self.parts, float("nan"))
        with np.errstate(over="ignore"):  # overflow of an unstable loop gives infinity
            return {
                name: float(np.mean(np.sum(v[start:] ** 2, axis=1)))
                for name, v in self.parts.items()
            }

    def spectrum(self, start: int = 0) -> tuple[Array, dict[str, Array]]:
        """Frequencies in rad/sample and the power spectral density of each signal.

        Averaged periodograms of at most 256 steps; their integral over frequency is the mean
        square of the steps that they cover.
        """
        from scipy.signal import welch

        length = len(self.residual) - start
        segment = max(min(256, length), 1)
        densities = {}
        for name, values in self.parts.items():
            omega, density = welch(
                values[start:],
                fs=2 * np.pi,
                window="boxcar",  # transients at the ends of a record count in full
                nperseg=segment,
                noverlap=0,
                detrend=False,
                axis=0,
            )
            densities[name] = np.asarray(density.sum(axis=1))
        return np.asarray(omega), densities


def split_residual(
    plant: Plant,
    compensator: Compensator,
    target: TargetModel,
    *,
    u: Array,
    y: Array,
    z: Array,
    w: Array,
) -> ResidualSplit:
    """Split the retrospective residual of recorded signals for the fixed controller theta*.

    The record must begin at rest (x(0) = 0, zero signals before k = 0); it may come from any
    controller, adaptive or not, for (4.14) holds for whatever u was applied.

    Parameters
    ----------
    plant : Plant
    compensator : Compensator
        theta*, for example ``run.compensator``.
    target : TargetModel
    u, y, z, w : arrays, shape (steps, width)

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, WhiteNoise, exogenous, fir_target, iir, simulate,
    ...     split_residual,
    ...     standard_plant)
    >>> plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=fir_target(plant), update=UD(R_theta=1))
    >>> run = simulate(plant, settings, exogenous([WhiteNoise()], steps=500))
    >>> split = split_residual(
    ...     plant, run.compensator, settings.target, u=run.u, y=run.y, z=run.z, w=run.w)
    >>> split.identity_error < 1e-12
    True
    """
    plant, compensator = linear_plant(plant), compensator_of(compensator)
    instance_of(target, "target", TargetModel)
    w = signal_array(w, "w", plant.l_w)
    steps = len(w)
    u = signal_array(u, "u", plant.l_u, steps)
    y = signal_array(y, "y", plant.l_y, steps)
    z = signal_array(z, "z", plant.l_z, steps)
    if (target.l_z, target.l_u) != (plant.l_z, plant.l_u):
        raise InputError(
            f"the target model is {target.l_z} x {target.l_u}; the plant's G_zu is "
            f"{plant.l_z} x {plant.l_u}."
        )
    u_tilde = u - pseudo_control(compensator, u, y)
    reference = filtered(target, u_tilde)
    loop = ClosedLoop(plant, compensator)
    still = np.zeros_like
    with np.errstate(over="ignore", invalid="ignore"):
        matched = loop.simulate(still(w), u_tilde)
        disturbed = loop.simulate(w, still(u))
    return ResidualSplit(
        u_tilde=u_tilde,
        residual=z - reference,
        matching_error=matched - reference,
        disturbance_response=disturbed,
    )


def pseudo_control(compensator: Compensator, u: Array, y: Array) -> Array:
    """Return u*(k) = Phi(k) theta* of (4.3): the fixed controller on the recorded signals."""
    result = np.zeros_like(u)
    for i, P in enumerate(compensator.past_u, start=1):
        result[i:] += u[: max(len(u) - i, 0)] @ P.T
    for i, Q in enumerate(compensator.past_y):
        result[i:] += y[: max(len(y) - i, 0)] @ Q.T
    return result


def filtered(target: TargetModel, u: Array) -> Array:
    """Return G_f(q) u from zero initial conditions; shape (steps, l_z)."""
    output = np.zeros((len(u), target.l_z))
    for i, N in enumerate(target.numerator):
        output[i:] += u[: max(len(u) - i, 0)] @ N.T
    if not target.denominator[1:].any():
        return output
    # The last n_f outputs are the state, the newest is the output.
    l_z, order = target.l_z, target.n_f * target.l_z
    A = np.eye(order, k=-l_z)
    A[:l_z] = -np.concatenate(target.denominator[1:], axis=1)
    return linear_states(A, np.pad(output, ((0, 0), (0, order - l_z))))[1:, :l_z]
