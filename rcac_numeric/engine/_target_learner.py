"""Target models updated from identified zeros during a run, section 3.6."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import integer, number, one_of
from rcac_numeric.arrays._values import Result, ShowsState
from rcac_numeric.engine._changes import COVARIANCES, ControllerChange
from rcac_numeric.engine._runs import Run
from rcac_numeric.identification._data_targets import DataTarget, target_from_data
from rcac_numeric.plants._any_plant import block_start
from rcac_numeric.plants._schedules import plant_at

# Rounding of a residual, relative to the signal.
ROUNDING = 1e-12


@dataclass(frozen=True, eq=False)
class LearnedTarget(Result):
    """The zeros identified in one window, and the action.

    Attributes
    ----------
    k : int
        The step.
    action : str
        "updated", "unchanged" where the zeros are those that the target has, or "refused".
    nmp_zeros : complex array
        Those identified; empty where the window was refused.
    reason : str
        Why it was refused.
    """

    k: int
    action: str
    nmp_zeros: ComplexArray
    reason: str = ""


class TargetLearner(ShowsState):
    """A hook of `simulate` that identifies the NMP zeros of G_zu and gives RCAC their target model.

    Before every step at which it is called it identifies the last `window` samples; where they
    carry a target model, (2.49) or (2.50), whose NMP zeros differ from those in use, that becomes
    G_f.

    Parameters
    ----------
    mu, n_mod, order : int
        As for `target_from_data`.
    window : int
        Samples.
    moved : float
        Zeros that moved by less leave the target model as it is.
    residual_growth : float
        A window whose residual, relative to z, is this many times the smallest so far holds a
        plant that changes, and is refused.
    covariance : {"keep", "blend", "reset", "replay"}
        As for `ControllerChange`.
    level, largest_error : float
        As for `target_from_data`.

    Raises
    ------
    InputError
        If a setting is out of range, or at a step where u or z is not scalar.

    Notes
    -----
    The input that is identified is u and, where it enters with u, the disturbance d: a dither is
    given as d, and must be known. The direct effect of a command r is taken off z. A loop that is
    at rest shows nothing: without a dither windows are refused, or decided by rounding.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric import (ControllerSettings, ModellingInformation, TargetLearner, UD,
    ...     fir_target, iir, servo_plant, simulate)
    >>> plant = servo_plant("(q - 1.5)/((q - 0.5)*(q - 0.6))")
    >>> w = np.zeros((120, 3))
    >>> w[:, 0], w[:, 1] = 1.0, 0.01 * np.random.default_rng(0).standard_normal(120)
    >>> settings = ControllerSettings(
    ...     structure=iir(4), target=fir_target(ModellingInformation(1, -1.0)), update=UD(10.0))
    >>> learner = TargetLearner(mu=6, n_mod=2, order=2, window=40)
    >>> run = simulate(plant, settings, w, on_step=learner, every=40)
    >>> [(window.k, window.action, window.nmp_zeros.real.round(6).tolist())
    ...  for window in learner.windows]
    [(40, 'updated', [1.5]), (80, 'unchanged', [1.5])]
    """

    SHOWN = ("mu", "n_mod", "order", "window")

    def __init__(
        self,
        mu: int,
        n_mod: int,
        order: int,
        *,
        window: int = 70,
        moved: float = 0.02,
        residual_growth: float = 30.0,
        covariance: str = "keep",
        level: float = 0.95,
        largest_error: float = 0.05,
    ) -> None:
        self.mu, self.n_mod = integer(mu, "mu", at_least=1), integer(n_mod, "n_mod")
        self.order, self.window = integer(order, "order"), integer(window, "window", at_least=1)
        self.moved = number(moved, "moved")
        self.residual_growth = number(residual_growth, "residual_growth")
        self.covariance = one_of(covariance, "covariance", COVARIANCES)
        self.level = number(level, "level")
        self.largest_error = number(largest_error, "largest_error")
        if not self.moved >= 0:
            raise InputError(f"moved = {self.moved:g}; a distance of zeros is at least 0.")
        if not self.residual_growth >= 1:
            raise InputError(f"residual_growth = {self.residual_growth:g}; it must be at least 1.")
        self._results: list[LearnedTarget] = []
        self._in_use: ComplexArray | None = None
        self._smallest = np.inf

    @property
    def windows(self) -> tuple[LearnedTarget, ...]:
        """The results of all windows so far."""
        return tuple(self._results)

    def __call__(self, run: Run) -> ControllerChange | None:
        """Return the change before the next step, or None."""
        k = run.first_step + run.steps
        if run.steps < self.window:
            self._refuse(k, f"only {run.steps} samples so far")
            return None
        u, z = acting_input(run)[-self.window :], _without_command(run)[-self.window :]
        try:
            data_target = target_from_data(
                u, z, self.mu, self.n_mod,
                order=self.order, level=self.level, largest_error=self.largest_error,
            )  # fmt: skip
        except CompensatorError as error:
            self._refuse(k, str(error))
            return None
        residual = _relative_residual(data_target, z)
        if residual > self.residual_growth * max(self._smallest, ROUNDING):
            self._refuse(
                k, f"the residual is {residual:.2g} of z, in an earlier window {self._smallest:.2g}"
            )
            return None
        self._smallest = min(self._smallest, residual)
        zeros = np.sort_complex(np.array(data_target.information.nmp_zeros, dtype=np.complex128))
        if self._is_in_use(zeros):
            self._results.append(LearnedTarget(k, "unchanged", zeros))
            return None
        self._in_use = zeros
        self._results.append(LearnedTarget(k, "updated", zeros))
        return ControllerChange(target=data_target.target, covariance=self.covariance)

    def _refuse(self, k: int, reason: str) -> None:
        self._results.append(LearnedTarget(k, "refused", np.zeros(0, np.complex128), reason))

    def _is_in_use(self, zeros: ComplexArray) -> bool:
        known = self._in_use
        if known is None or len(known) != len(zeros):
            return False
        return bool(np.abs(known - zeros).max(initial=0.0) <= self.moved)


def acting_input(run: Run) -> Array:
    """Return the applied control plus the input disturbance."""
    plant = plant_at(run.plant, 0)
    if "d" not in plant.blocks:
        return run.u_applied
    first = block_start(plant, "d")
    columns = slice(first, first + plant.blocks["d"])
    if not np.array_equal(plant.D_1[:, columns], plant.B):
        return run.u_applied
    return np.asarray(run.u_applied + run.w[:, columns])


def _without_command(run: Run) -> Array:
    plant = plant_at(run.plant, 0)
    if "r" not in plant.blocks:
        return run.z
    first = block_start(plant, "r")
    columns = slice(first, first + plant.blocks["r"])
    return np.asarray(run.z - run.w[:, columns] @ plant.E_0[:, columns].T)


def _relative_residual(data_target: DataTarget, z: Array) -> float:
    size = float(np.sqrt(np.mean(z**2)))
    return float(np.sqrt(np.mean(data_target.markov.residual**2))) / size if size > 0 else 0.0
