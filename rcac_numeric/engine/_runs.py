"""The result of a closed-loop run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory import figures
from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._frames import DataFrame, Dataset, imported
from rcac_numeric.arrays._record_files import read_record, write_record
from rcac_numeric.arrays._records import Records, require_declared
from rcac_numeric.arrays._showing import notebook_of
from rcac_numeric.arrays._validation import (
    instance_of,
    integer,
    one_of,
    real_array,
    rounded,
    signal_array,
)
from rcac_numeric.arrays._values import Value, replaced
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.controllers._bounds import CertifiedBounds, CoefficientBounds
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._decentralized import Decentralized
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._forgetting import (
    CappedForgetting,
    ScheduledForgetting,
    SubspaceForgetting,
    VariableRateForgetting,
)
from rcac_numeric.controllers._gain_schedule import GainSchedule
from rcac_numeric.controllers._joint import JointUD
from rcac_numeric.controllers._limits import ControlLimits
from rcac_numeric.controllers._memoryless import Gradient, Instantaneous
from rcac_numeric.controllers._normalization import Normalization
from rcac_numeric.controllers._predictive_cost import PredictiveCost
from rcac_numeric.controllers._recursive import UD, Covariance
from rcac_numeric.controllers._resets import CovarianceReset
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._sliding_window import SlidingWindow
from rcac_numeric.controllers._structure import DerivedSignal, Structure, Tap
from rcac_numeric.controllers._supervision import (
    SupervisionEvent,
    SupervisionRecord,
    TroubleCount,
)
from rcac_numeric.controllers._weights import SignalWeight
from rcac_numeric.engine._changes import AppliedChange, ControllerChange
from rcac_numeric.engine._compatibility import AnyController, require_fit
from rcac_numeric.engine._states import SavedState
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._linear import MATRICES, Plant
from rcac_numeric.plants._saturation import Saturation
from rcac_numeric.plants._schedules import PlantChange, PlantSchedule
from rcac_numeric.targets._data_driven import DataDriven
from rcac_numeric.targets._model import TargetModel

# Classes that the file of a run may contain; no other class is constructed from a file.
RECORDS = Records(
    AppliedChange, CappedForgetting, CertifiedBounds, CoefficientBounds, Compensator,
    ControllerChange, ControllerSettings, ControlLimits, Covariance, CovarianceReset, DataDriven,
    Decentralized, DerivedSignal, FixedController, GainSchedule, Gradient, Instantaneous, JointUD,
    Normalization, Plant, PlantChange, PlantSchedule, PredictiveCost, Saturation, SavedState,
    ScheduledForgetting, SignalWeight, SlidingWindow, Structure, SubspaceForgetting,
    SupervisionEvent, SupervisionRecord, Tap, TargetModel, TroubleCount, UD, VariableRateForgetting,
)  # fmt: skip

# Outcomes of a run, in the order of the kernel's indices.
OUTCOMES = (
    "completed",
    "diverged",
    "overflow",
    "plant not finite",
    "plant failed",
    "unsupported R_theta",
)
# The kernel reports the first of these as "overflow".
OTHER_OUTCOMES = ("weight failed", "interrupted")


@dataclass(frozen=True, eq=False)
class Run(Value):
    """A closed-loop run: signals, coefficients, outcome.

    Attributes
    ----------
    plant, settings : the arguments of the run.
    w, u, y, z : arrays, shape (steps, width)
        The signals at k = first_step, first_step + 1, ....
    u_applied : array, shape (steps, l_u)
        What the actuator made of u; u itself without saturation.
    theta : array, shape (ceil(steps / stride), l_theta)
        theta[j] made u at step first_step + j * stride.
    theta_final : array, shape (l_theta,)
        The coefficients after the last completed step.
    outcome : str
        "completed"; "diverged" (a signal, a state or a coefficient exceeded the limit);
        "overflow" (the update left the range of float64: with lambda < 1 P grows like lambda^-k in
        directions without excitation, which a `reset` or lambda = 1 prevents); "plant not
        finite"; "plant failed" (a function returned nonzero or raised); "weight failed" (a weight
        that is a function raised or returned no weight); "unsupported R_theta" (an
        update was decided by rounding and the settings ask to stop there); "interrupted" (Ctrl-C).
        The arrays end before the failed step.
    guard_count, guard_first_step : int
        Updates decided by rounding and the first such step (-1: none): for UD, a direction
        that the data excite by no more than their rounding errors while R_theta is so small that
        theta follows them; for Covariance, Upsilon not positive. Not zero: the data cannot
        support this R_theta in this arithmetic.
    reflections, resets : int
        Updates after which poles were reflected (6.2.2), and covariance resets.
    bounded : int
        Updates after which theta was outside its bounds and was moved to them.
    state : SavedState, optional
        From which `simulate` continues bit for bit; None where the run failed.
    failure : str
        What a function of the plant or of a weight raised; empty where none did.
    changes : tuple of AppliedChange
        What was changed in the controller while it ran, and why.
    D_f : array, shape (n_d + 1,), or None
        With `JointUD` the denominator 1, d_1, ..., d_n that was fitted with theta_final.
    supervision : SupervisionRecord, optional
        What the supervision of the one adaptive controller noted and did.
    """

    plant: AnyPlant
    settings: AnyController
    w: Array
    u: Array
    y: Array
    z: Array
    theta: Array
    theta_final: Array
    stride: int
    outcome: str
    guard_count: int
    guard_first_step: int
    u_applied: Array
    reflections: int = 0
    resets: int = 0
    bounded: int = 0
    first_step: int = 0
    state: SavedState | None = None
    saturation: Saturation | None = None
    x_0: Array | None = None
    divergence_limit: float = math.inf
    failure: str = ""
    changes: tuple[AppliedChange, ...] = ()
    D_f: Array | None = None
    supervision: SupervisionRecord | None = None

    @property
    def steps(self) -> int:
        """Number of completed steps."""
        return len(self.u)

    @property
    def radius(self) -> Array | None:
        """The share of the radius of `CertifiedBounds` that each theta uses; None without them.

        0 is the center, 1 the boundary, which no theta exceeds. None also for several controllers.
        """
        bounds = self.settings.bounds if isinstance(self.settings, ControllerSettings) else None
        return bounds.radius_of(self.theta) if isinstance(bounds, CertifiedBounds) else None

    @property
    def compensator(self) -> Compensator:
        """The controller after the last completed step."""
        return self._timed(self.settings.compensator_of(self.theta_final))

    @property
    def sample_time(self) -> float | None:
        """Sample time of the plant in seconds, for a schedule of its first plant; None if unknown.

        ``run.compensator.to_control()`` goes back to python-control with it.
        """
        plant = self.plant.first if isinstance(self.plant, PlantSchedule) else self.plant
        return plant.sample_time if isinstance(plant, Plant) else None

    def compensator_at(self, k: int) -> Compensator:
        """Return the controller at step k, for a step at which theta was stored."""
        row, rest = divmod(integer(k, "k") - self.first_step, self.stride)
        if rest or not 0 <= row < len(self.theta):
            raise InputError(
                f"theta({k}) was not stored; theta is stored at multiples of {self.stride} below "
                f"{self.steps}."
            )
        return self._timed(self.settings.compensator_of(self.theta[row]))

    def _timed(self, compensator: Compensator) -> Compensator:
        if self.sample_time in (None, compensator.sample_time):
            return compensator
        return replaced(compensator, sample_time=self.sample_time)

    @property
    def k(self) -> Array:
        """The steps of the signals, first_step, first_step + 1, ...."""
        return self.first_step + np.arange(self.steps, dtype=np.float64)

    def to_pandas(self) -> DataFrame:
        """Return a DataFrame over k: z, u, y, w, u_applied and theta, components numbered from 1.

        With `CertifiedBounds` also radius. With a stride, theta and radius are NaN between the
        stored steps.

        Raises
        ------
        InputError
            Where pandas is not installed.
        """
        columns = {"k": self.k}
        for name, values in self._by_name().items():
            for i, column in enumerate(values.T):
                columns[name if values.shape[1] == 1 else f"{name}{i + 1}"] = column
        return imported("pandas").DataFrame(columns).set_index("k")

    def to_xarray(self) -> Dataset:
        """Return a Dataset with the dimension k and a dimension of components for each signal.

        Raises
        ------
        InputError
            Where xarray is not installed.
        """
        by_name = self._by_name()
        variables = {name: (("k", f"{name}_component"), v) for name, v in by_name.items()}
        attributes = {"outcome": self.outcome, "guard_count": self.guard_count}
        return imported("xarray").Dataset(variables, {"k": self.k}, attributes)

    def _by_name(self) -> dict[str, Array]:
        stored = {"theta": self.theta}
        if self.radius is not None:
            stored["radius"] = self.radius[:, None]
        signals = {name: getattr(self, name) for name in ("z", "u", "y", "w", "u_applied")}
        for name, values in stored.items():
            signals[name] = np.full((self.steps, values.shape[1]), np.nan)
            signals[name][:: self.stride] = values
        return signals

    def save(self, path: str | Path) -> None:
        """Write the run to a .npz file that `load_run` and `rcac check` read, bit for bit.

        Raises
        ------
        InputError
            Where the file cannot be written, or the run is of a subclass of `Run`.
        """
        if type(self) is not Run:
            raise InputError(f"a {type(self).__name__} cannot be saved; a Run can.")
        write_record(path, "run", {f.name: getattr(self, f.name) for f in fields(self)}, RECORDS)

    def plot(
        self,
        *,
        signals: Sequence[str] = ("z", "u", "theta"),
        width: float = 9.0,
        ax: Any = None,
    ) -> figures.Figure:
        """Plot z, u and theta over the step k, or in seconds.

        Parameters
        ----------
        signals, width, ax
            As for `plot_runs`: what is drawn, how wide, and in which axes.
        """
        from rcac_numeric.plots._runs import plot_runs

        return plot_runs([self], signals=signals, width=width, ax=ax)

    def _sheet(self) -> Any:
        from rcac_numeric.reports._loop import run_sheet

        return run_sheet(self)

    def _repr_html_(self) -> str:
        """Return the notebook view: outcome and plots."""
        return notebook_of(self._sheet(), self.plot if self.steps else None)

    def __repr__(self) -> str:
        return f"Run({self.outcome}, steps={self.steps}, {self.plant!r})"


def load_run(
    path: str | Path, *, plant: AnyPlant | None = None, settings: AnyController | None = None
) -> Run:
    """Read a run that `Run.save` wrote; it equals the one that was saved.

    Parameters
    ----------
    path : path
    plant, settings : optional
        The plant and the settings of the run, required where they hold Python functions, which a
        file cannot hold.

    Raises
    ------
    InputError
        Where the file cannot be read, is too large, is damaged, or holds no valid run.

    Notes
    -----
    The file holds data only: no code in it is executed. Python functions of the plant or the
    settings come from the arguments. The checksum detects damage, not another author.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, Step, exogenous, fir_target, iir, load_run, simulate,
    ...     standard_plant)
    >>> plant = standard_plant("1/(q - 0.9)")
    >>> settings = ControllerSettings(structure=iir(2), target=fir_target(plant), update=UD(1e-3))
    >>> run = simulate(plant, settings, exogenous([Step()], steps=100))
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "run.npz"
    >>> run.save(file)
    >>> load_run(file) == run
    True
    """
    parts = read_record(path, "run", RECORDS, {"plant": plant, "settings": settings})
    try:
        run = Run(**parts)
        require_declared(run)
        if plant is None:
            instance_of(run.plant, "plant", Plant | PlantSchedule)
        require_consistent(run)
    except (CompensatorError, TypeError) as error:
        words = shortened(str(error).rstrip("."), 300)
        raise InputError(f"{path} holds no consistent run: {words}.") from None
    return run


def require_consistent(run: Run) -> None:
    """Raise if the parts of a run, for instance from a file, are inconsistent.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from rcac_numeric import Compensator, FixedController, simulate, standard_plant
    >>> from rcac_numeric.engine._runs import require_consistent
    >>> fixed = FixedController(Compensator(past_u=[[[0.0]]], past_y=[[[0.0]], [[-0.1]]]))
    >>> run = simulate(standard_plant("1/(q - 0.9)"), fixed, [[1.0]] * 100)
    >>> require_consistent(run)
    >>> require_consistent(replace(run, u=run.u[:3]))
    Traceback (most recent call last):
        ...
    compensator_theory.errors.InputError: u has shape (3, 1); (100, 1) is needed.
    """
    plant, settings = run.plant, run.settings
    for one in _linear_plants(plant):
        _require_exact_form(one)
    require_fit(plant, settings)
    integer(run.stride, "stride", at_least=1)
    integer(run.first_step, "first_step", at_most=2**53)
    integer(run.guard_first_step, "guard_first_step", at_least=-1)
    for name in ("guard_count", "reflections", "resets", "bounded"):
        integer(getattr(run, name), name)
    one_of(run.outcome, "outcome", (*OUTCOMES, *OTHER_OUTCOMES))
    if not run.divergence_limit > 0:
        raise InputError(f"divergence_limit = {run.divergence_limit} must be positive.")
    steps = len(signal_array(run.w, "w", plant.l_w))
    shapes = {
        "u": (steps, plant.l_u),
        "u_applied": (steps, plant.l_u),
        "y": (steps, plant.l_y),
        "z": (steps, plant.l_z),
        "theta": (-(-steps // run.stride), settings.l_theta),
        "theta_final": (settings.l_theta,),
    }
    if run.x_0 is not None:
        real_array(run.x_0, "x_0")
        shapes["x_0"] = (plant.n,)
    if run.D_f is not None:
        update = settings.update if isinstance(settings, ControllerSettings) else None
        n_d = update.n_d if isinstance(update, JointUD) else -1
        shapes["D_f"] = (n_d + 1,)
    for name, shape in shapes.items():
        if getattr(run, name).shape != shape:
            raise InputError(f"{name} has shape {getattr(run, name).shape}; {shape} is needed.")
    if run.saturation is not None:
        run.saturation.bounds(plant.l_u)
    if run.state is not None and (run.state.kind, run.state.k) != ("loop", run.first_step + steps):
        raise InputError(
            f"its state is one of a {run.state.kind} after {run.state.k} steps; that of a loop "
            f"after {run.first_step + steps} is needed."
        )


def _linear_plants(plant: AnyPlant) -> list[Plant]:
    if isinstance(plant, PlantSchedule):
        return [change.plant for change in plant.changes]
    return [plant] if isinstance(plant, Plant) else []


def _require_exact_form(plant: Plant) -> None:
    """Raise if the matrices of the exact form do not round to those of the plant."""
    if plant.exact is None:
        return
    for name in MATRICES:
        values, exact = getattr(plant, name), getattr(plant.exact, name)
        if exact.shape != values.shape or rounded([*exact], name).tolist() != [*values.ravel()]:
            raise InputError(f"{name} of its plant is not that of the plant's exact form.")
