"""Settings of an RCAC controller, checked, as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, Literal, cast

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import ImproperError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import (
    array_like,
    by_step,
    instance_of,
    integer,
    items,
    one_of,
    reads,
    real_array,
    with_checks,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._bounds import CertifiedBounds, CoefficientBounds
from rcac_numeric.controllers._compensator import Compensator, parallel
from rcac_numeric.controllers._joint import JointUD
from rcac_numeric.controllers._normalization import Normalization
from rcac_numeric.controllers._prior import PriorSamples
from rcac_numeric.controllers._recursive import UD, Covariance
from rcac_numeric.controllers._regressor import filtered_regressor, has_common_filter, regressor_of
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.controllers._update import Update
from rcac_numeric.controllers._weights import SignalWeight, Weight, WeightFunction, weight
from rcac_numeric.targets._data_driven import DataDriven
from rcac_numeric.targets._model import TargetModel

FORMS = ("predictor", "filter")


def _intervals(value: object, name: str) -> tuple[tuple[int, int | None], ...]:
    return tuple(interval(pair) for pair in items(value, name))


# Argument types of converted fields, for type checkers.


def _target_like(value: TargetModel | DataDriven) -> TargetModel:
    return cast(TargetModel, value)


def _weight_like(value: ArrayLike | SignalWeight | WeightFunction) -> Weight:
    return cast(Weight, value)


def _step_like(value: int | None) -> int:
    return cast(int, value)


def _theta_like(value: ArrayLike | None) -> Array:
    return cast(Array, value)


def _changes_like(value: Mapping[int, TargetModel] | None) -> Mapping[int, TargetModel]:
    return cast(Mapping[int, TargetModel], value)


@attrs.frozen(eq=False, slots=False, kw_only=True, field_transformer=with_checks)
class ControllerSettings(Value):
    """Everything that determines an RCAC controller, as plain data.

    Parameters
    ----------
    structure : Structure
        What the regressor is made of, for example ``iir(n_c=4)``.
    target : TargetModel or DataDriven
        G_f, with l_z rows and l_u columns; or how the controller learns it while it runs, which is
        kept in `learning`.
    update : UD, Covariance, SlidingWindow, JointUD, Instantaneous or Gradient
        How theta is updated; R_theta, forgetting and what else belongs to it are its own.
    R_z, R_u : float, array of shape (l_z, l_z), SignalWeight, or function
        Weights of (2.41); R_z positive definite, R_u positive semidefinite. A function is called
        as R(k, y, z, u) at every update and returns a number or a matrix; u is u(k), or u(k-1) in
        the filter form.
    k_w : int, optional
        First step with u = Phi theta; u = 0 before. max(n_c, n_f) by default, and at least that
        where the update begins with it: as the text runs its examples, not the best there is. From
        theta(0) = 0 with a plant that stays where it is, five times that is safer (`cold_start`);
        a theta(0) that is a controller has k_w = 0 (`design`).
    k_update : int, optional
        First step of the update; k_w by default. With ``k_w=0`` and a k_update of at least
        max(n_c, n_f) the controller theta_0 has the loop from its first step on, as one that is
        good already should: to wait while y moves gives it a past that it never had.
    k_filter : int
        First step that the target-model filter sees; 0 by default.
    theta_0 : array, shape (l_theta,), optional
        theta(0); zero by default.
    form : {"predictor", "filter"}
        "filter" is (2.47)-(2.48): the update with z(k) comes before the control u(k) of the same
        step. (As printed, (2.47) mixes Phi_f(k+1) with Upsilon(k); both belong to k+1 here.)
    target_changes : mapping from steps to TargetModel, optional
        G_f from that step on. The filter keeps the past inputs and outputs of the old one.
    freeze : sequence of (start, stop)
        Steps start <= k < stop without update; stop = None: to the end.
    reflect_poles : bool
        Replace unstable controller poles by their reciprocals after every update (section
        6.2.2); l_u = 1.
    R_u_unfiltered : float or array of shape (l_u, l_u)
        Weight of Phi(k) theta, (Phi(k) theta)' R_u_unfiltered (Phi(k) theta), added to the cost of
        step k beside that of Phi_f theta, which R_u weighs; zero by default.
    z_normalization : Normalization, optional
        z in the cost becomes f(z); rules and weights see z itself.
    bounds : CoefficientBounds or CertifiedBounds, optional
        Of theta, kept after every update.
    fixed : Compensator, optional
        From [y; r], in parallel and from step 0 on: u = v + Phi theta. The regressor and the
        target-model filter hold Phi theta, or what an actuator left of it, u_applied - v: for RCAC
        v belongs to the plant.
    learning : DataDriven, optional
        The other way to say it: `target` then is what stands there until the first look.

    Raises
    ------
    InputError
        Where a setting is out of range or has the wrong shape.
    ImproperError
        Where the filter form meets a target model that is not strictly proper.

    Examples
    --------
    >>> from rcac_numeric import ControllerSettings, TargetModel, UD, iir
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=3), target=TargetModel([0, 1]), update=UD(R_theta=0.2))
    >>> settings.k_w, settings.k_update, settings.update
    (3, 3, UD(R_theta=0.2))
    """

    structure: Structure
    target: TargetModel = attrs.field(converter=_target_like)
    update: Update
    R_z: Weight = attrs.field(default=_weight_like(1.0), converter=_weight_like)
    R_u: Weight = attrs.field(default=_weight_like(0.0), converter=_weight_like)
    k_w: int = attrs.field(default=None, converter=_step_like)
    k_update: int = attrs.field(default=None, converter=_step_like)
    k_filter: int = 0
    theta_0: Array = attrs.field(default=None, converter=_theta_like)
    form: Literal["predictor", "filter"] = attrs.field(
        default="predictor", metadata=reads(one_of, choices=FORMS)
    )
    target_changes: Mapping[int, TargetModel] = attrs.field(
        factory=dict, converter=_changes_like, metadata=reads(by_step)
    )
    freeze: Sequence[tuple[int, int | None]] = attrs.field(default=(), metadata=reads(_intervals))
    reflect_poles: bool = attrs.field(default=False, metadata=reads(instance_of, kind=bool))
    R_u_unfiltered: Array = attrs.field(default=0.0, converter=array_like)
    z_normalization: Normalization | None = attrs.field(
        default=None, metadata=reads(instance_of, optional=True, kind=Normalization)
    )
    bounds: CoefficientBounds | CertifiedBounds | None = attrs.field(
        default=None,
        metadata=reads(instance_of, optional=True, kind=CoefficientBounds | CertifiedBounds),
    )
    fixed: Compensator | None = attrs.field(
        default=None, metadata=reads(instance_of, optional=True, kind=Compensator)
    )
    learning: DataDriven | None = None

    def __attrs_post_init__(self) -> None:
        set_, structure, update = partial(object.__setattr__, self), self.structure, self.update
        if not isinstance(structure, Structure):
            raise InputError(f"structure = {structure!r}: use iir(...), fir(...) or another kind.")
        if not isinstance(update, Update):
            raise InputError(f"update = {update!r}: use UD(R_theta=...) or another update.")
        if isinstance(self.target, DataDriven):
            set_("learning", self.target)
            set_("target", self.target.first_target)
        target = self.target
        if self.learning is not None:
            require_learnable(self.learning, structure, target.l_z)
            if self.target_changes or self.freeze:
                raise InputError(
                    "DataDriven changes the target model itself, and no update precedes its first "
                    "target model; leave target_changes and freeze out."
                )
        for model in self.targets:
            require_target(model, structure, target)
        if isinstance(prior := getattr(update, "R_theta", None), PriorSamples):
            if self.learning is not None:
                raise InputError("PriorSamples needs a target model from the start; give a number.")
            known = prior_weight(prior, structure, target)
            update = attrs.evolve(update, R_theta=known)  # type: ignore[misc]
            set_("update", update)
        update.require_size(structure.l_theta)
        set_("R_z", weight(self.R_z, "R_z", target.l_z, definite=True))
        set_("R_u", weight(self.R_u, "R_u", target.l_z, definite=False))
        penalty = constant_weight(
            self.R_u_unfiltered, "R_u_unfiltered", structure.l_u, definite=False
        )
        set_("R_u_unfiltered", penalty)
        penalises = not isinstance(self.R_u, np.ndarray) or bool(self.R_u.any() or penalty.any())
        update.require_problem(self.targets, structure.n_c, penalises)
        first_step: int | None = self.k_w
        if first_step is None and self.learning is not None:
            first_step = self.learning.start
        self._read_start(first_step, self.k_update, self.k_filter)
        start = np.zeros(structure.l_theta) if self.theta_0 is None else self.theta_0
        set_("theta_0", real_array(start, "theta_0").reshape(-1))
        if self.theta_0.size != structure.l_theta:
            raise InputError(
                f"theta_0 has {self.theta_0.size} entries; l_theta = {structure.l_theta} are "
                "needed."
            )
        if self.form == "filter" and any(t.relative_degree == 0 for t in self.targets):
            raise ImproperError(
                'form = "filter" updates before u(k) is known, so the target model must be '
                "strictly proper."
            )
        if self.reflect_poles:
            require_reflectable(structure)
        if self.z_normalization is not None and isinstance(update, JointUD):
            raise InputError("JointUD fits D_f to z itself; leave z_normalization out.")
        if self.bounds is not None:
            require_bounds(self.bounds, structure, update, self.theta_0, self.reflect_poles)
        if self.fixed is not None:
            require_fixed(self.fixed, structure)

    def _read_start(self, k_w: int | None, k_update: int | None, k_filter: int) -> None:
        set_ = partial(object.__setattr__, self)
        longest = max(target.n_f for target in self.targets)
        shortest = max(self.structure.n_c, longest)
        set_("k_w", shortest if k_w is None else integer(k_w, "k_w"))
        if self.learning is not None and self.k_w < self.learning.start:
            raise InputError(
                f"k_w = {k_w} must be at least {self.learning.start}: DataDriven excites the "
                f"plant until step {self.learning.start} (start={self.learning.start}). Use a "
                f"larger k_w, or an earlier start."
            )
        set_("k_update", self.k_w if k_update is None else integer(k_update, "k_update"))
        if self.k_w < shortest and self.k_update < shortest:
            raise InputError(
                f"k_w = {k_w} is shorter than max(n_c, n_f) = max({self.structure.n_c}, "
                f"{longest}) = {shortest}: the regressor and the target-model filter would "
                f"contain zeros from before step 0. Use k_w >= {shortest}, or k_update >= "
                f"{shortest} where "
                "theta_0 is a controller already."
            )
        set_("k_filter", integer(k_filter, "k_filter"))

    @property
    def targets(self) -> tuple[TargetModel, ...]:
        """The target models in the order of use."""
        return (self.target, *self.target_changes.values())

    @property
    def measures_first(self) -> bool:
        """Whether u(k) uses y(k), by a tap or by the fixed compensator in parallel."""
        direct = self.fixed is not None and bool(self.fixed.past_y[0].any())
        return direct or self.structure.measures_first

    @property
    def l_theta(self) -> int:
        """Number of coefficients that are adapted."""
        return self.structure.l_theta

    @property
    def l_r(self) -> int:
        """Number of commands that the controller reads."""
        return self.structure.l_r

    def compensator_of(self, theta: ArrayLike) -> Compensator:
        """Return the compensator of the coefficients `theta`, `fixed` included."""
        adaptive = self.structure.compensator(theta)
        return adaptive if self.fixed is None else parallel(self.fixed, adaptive)


# Fast copies of settings with other numbers.


def settings_with_numbers(
    settings: ControllerSettings, of_update: Mapping[str, Any], of_settings: Mapping[str, Any]
) -> ControllerSettings | None:
    """Return a copy with other R_theta, lambda, R_z, R_u, theta_0, k_w and k_update.

    The other checks do not depend on these numbers and are not repeated.
    Return None where a number would replace a function, a signal or an array.
    """
    update, l_z = settings.update, settings.target.l_z
    changed: dict[str, Any] = {}
    weights = {"R_z": settings.R_z, "R_u": settings.R_u}
    if type(settings) is not ControllerSettings or settings.learning is not None:
        return None
    if of_update:
        if not isinstance(update, UD | Covariance) or type(update) not in (UD, Covariance):
            return None
        if type(update.lambda_) is not float or type(update.R_theta) is not float:
            return None
        if not all(map(_is_number, of_update.values())):
            return None
        other = attrs.evolve(update, **of_update)
        other.require_size(settings.structure.l_theta)
        changed["update"] = other
    for name, value in of_settings.items():
        if name == "theta_0":
            theta_0 = real_array(value, name)
            if settings.bounds is not None or theta_0.shape != settings.theta_0.shape:
                return None
            changed[name] = theta_0
        elif name in ("k_w", "k_update"):
            if value is not None and type(value) is not int:
                return None
        elif _is_number(value) and isinstance(weights[name], np.ndarray):
            changed[name] = weight(value, name, l_z, definite=name == "R_z")
        else:
            return None
    settings_copy = object.__new__(ControllerSettings)
    settings_copy.__dict__.update(settings.__dict__, **changed)
    if "k_w" in of_settings:
        settings_copy._read_start(
            of_settings["k_w"], of_settings["k_update"], settings_copy.k_filter
        )
    if "R_u" in changed:
        penalises = bool(settings_copy.R_u.any() or settings_copy.R_u_unfiltered.any())  # type: ignore[union-attr]
        settings_copy.update.require_problem(
            settings_copy.targets, settings_copy.structure.n_c, penalises
        )
    return settings_copy


def _is_number(value: object) -> bool:
    return type(value) in (int, float)


# Checks of settings.


def require_learnable(learning: DataDriven, structure: Structure, l_z: int) -> None:
    """Raise if DataDriven cannot learn a target model for this structure."""
    instance_of(learning, "learning", DataDriven)
    widths = structure.l_u, l_z
    if widths != (1, 1):
        raise InputError(
            f"DataDriven learns a target model for scalar u and z; here (l_u, l_z) = {widths}."
        )
    if not learning.is_frozen or learning.n is None:
        return
    if structure.derived:
        raise InputError(
            f'input = "frozen u~" is for a regressor of u, y and r; this {structure.name} '
            'structure derives signals of its own. Use input = "u".'
        )
    if learning.order < (least := learning.n + structure.n_c):
        raise InputError(
            f"order = {learning.order} is below n + n_c = {learning.n} + {structure.n_c}: from u~ "
            "to z the loop has that order, and a model of a lower one is biased for good. Use "
            f'order = {least} or more, or input = "u".'
        )


def require_target(model: object, structure: Structure, first: TargetModel) -> None:
    """Raise if a target model does not fit the structure or the first target model."""
    if not isinstance(model, TargetModel):
        raise InputError(
            f"target = {model!r}: use fir_target, pole_placement_target or target_model."
        )
    if model.l_u != structure.l_u:
        raise InputError(
            f"the target model has {model.l_u} columns and the structure {structure.l_u} "
            "control inputs; G_f must be l_z x l_u."
        )
    if model.l_z != first.l_z:
        raise InputError(f"the target models have {first.l_z} and {model.l_z} rows.")


def require_reflectable(structure: Structure) -> None:
    """Raise if the poles of a structure do not determine its coefficients of u."""
    if structure.l_u != 1:
        raise InputError(
            f"reflect_poles needs l_u = 1; this structure has l_u = {structure.l_u}, "
            "where reflecting the roots of det D_c does not determine the coefficients."
        )
    lags = sorted(tap.delay for tap in structure.taps if tap.signal == "u")
    if not lags or lags != list(range(1, len(lags) + 1)):
        raise InputError(
            "reflect_poles needs the taps u(k-1), ..., u(k-n) without gaps; this "
            f"{structure.name} structure has the lags {lags} of u."
        )


def interval(pair: tuple[int, int | None]) -> tuple[int, int | None]:
    """Return a pair (start, stop) of steps; stop may be None."""
    try:
        start, stop = pair
    except (TypeError, ValueError):
        raise InputError(
            f"freeze has the entry {pair!r}; pairs (start, stop) are needed."
        ) from None
    first = integer(start, "start of freeze")
    if stop is not None and integer(stop, "stop of freeze") <= first:
        raise InputError(f"freeze has the empty interval ({start}, {stop}).")
    return first, stop


def require_bounds(
    bounds: CoefficientBounds | CertifiedBounds,
    structure: Structure,
    update: Update,
    theta_0: Array,
    reflects: bool,
) -> None:
    """Raise if bounds do not fit the structure, the update, theta(0) or pole reflection."""
    if reflects:
        raise InputError(
            "reflect_poles may move the coefficients of u outside their bounds; use one of the two."
        )
    if isinstance(bounds, CertifiedBounds):
        _require_inside(bounds, structure, theta_0)
        return
    low, high = bounds.box(structure)
    outside = np.flatnonzero((theta_0 < low) | (theta_0 > high))
    if len(outside):
        i = int(outside[0])
        raise InputError(
            f"theta_0[{i}] = {theta_0[i]:g} is outside its bounds {low[i]:g} and {high[i]:g}; "
            "start inside them."
        )
    if isinstance(update, JointUD) and bounds.method == "metric":
        raise InputError(
            "JointUD fits D_f with theta, and the metric of P would move both; use bounds with "
            'method = "clip".'
        )


def _require_inside(bounds: CertifiedBounds, structure: Structure, theta_0: Array) -> None:
    """Raise if an ellipsoid has another size than theta, or theta(0) is outside."""
    size = bounds.center.size
    if size != structure.l_theta:
        raise InputError(
            f"the bounds have a center of {size} entries; l_theta = {structure.l_theta} are needed."
        )
    if not bounds.contains(theta_0):
        raise InputError(
            f"theta_0 is outside its bounds, at {bounds.radius_of(theta_0):.3g} of their radius; "
            "start inside them, for example at theta_0 = center."
        )


def require_fixed(fixed: Compensator, structure: Structure) -> None:
    """Raise if the parallel compensator has other inputs or outputs than the controller."""
    widths, expected = (fixed.l_u, fixed.l_y), (structure.l_u, structure.l_y + structure.l_r)
    if widths != expected:
        raise InputError(
            f"fixed has {widths[1]} inputs and {widths[0]} outputs; beside this structure it reads "
            f"[y; r] with {expected[1]} components and adds to u with {expected[0]}."
        )


FLOOR = 1e-4  # floor, relative to the diagonal of the mean of Phi_f' Phi_f
SLOWEST = 0.99  # an integrator counts as a lag of this many steps
FREQUENCIES = 4097  # number of frequencies for the mean gain of G_f


def prior_weight(prior: PriorSamples, structure: Structure, target: TargetModel) -> Array:
    """Return R_theta = samples * mean(Phi_f' Phi_f), of a record or of white signals."""
    widths = structure.l_u, structure.l_y, structure.l_r
    for name, signal, width in zip("uyr", (prior.u, prior.y, prior.r), widths, strict=True):
        if signal is None:
            if name == "r" and width:
                raise InputError("the structure reads r: give PriorSamples its size or record.")
            continue
        if width and signal.shape[-1] not in ((width,) if prior.is_record else (1, width)):
            raise InputError(
                f"PriorSamples: {name} has {signal.shape[-1]} components, and the structure reads "
                f"{width}."
            )
    if not prior.is_record:
        return prior.samples * _of_sizes(prior, structure, target)
    if not has_common_filter(target):
        raise InputError(
            "the target model has a denominator of its own for each output: give PriorSamples "
            "the sizes of y and u, and no record."
        )
    assert prior.u is not None
    return prior.samples * mean_information(structure, target, prior.u, prior.y, prior.r)


def mean_information(
    structure: Structure, target: TargetModel, u: Array, y: Array, r: Array | None = None
) -> Array:
    """Return the mean of Phi_f' Phi_f over a record, with a floor of 1e-4 of its diagonal."""
    phi = regressor_of(structure, {"u": u, "y": y, "r": r}, np.asarray)
    Phi_f = filtered_regressor(phi, target).reshape(-1, structure.l_theta)
    information = Phi_f.T @ Phi_f / len(phi)
    information = (information + information.T) / 2
    return information + FLOOR * np.diag(np.diag(information))


def _of_sizes(prior: PriorSamples, structure: Structure, target: TargetModel) -> Array:
    """Return the mean of Phi_f' Phi_f of independent white signals of these sizes."""
    omega = np.linspace(0, np.pi, FREQUENCIES)
    responses, past = target.frequency_response(omega), np.exp(-1j * omega)
    weights = np.r_[0.5, np.ones(FREQUENCIES - 2), 0.5] / (FREQUENCIES - 1)
    spectrum = np.einsum("w,wzi,wzj->wij", weights, responses.conj(), responses)
    through = np.linalg.norm(prior.y) / np.sqrt(np.diag(spectrum.sum(axis=0).real))
    sizes = np.concatenate([
        np.broadcast_to(through if prior.u is None else prior.u, structure.l_u),
        np.broadcast_to(prior.y, structure.l_y),
        np.broadcast_to(0.0 if prior.r is None else prior.r, structure.l_r),
    ])  # fmt: skip
    first = {"u": 0, "y": structure.l_u, "r": structure.l_u + structure.l_y}
    reads = np.zeros((len(sizes), len(structure.taps), FREQUENCIES), dtype=np.complex128)
    for i, tap in enumerate(structure.taps):
        late = past**tap.delay
        if tap.signal != "derived":
            reads[first[tap.signal] + tap.component, i] = late
            continue
        derived = structure.derived[tap.component]
        lag = late / (1 - np.clip(derived.pole, -SLOWEST, SLOWEST) * past)
        for j, (now, before) in enumerate(zip(derived.now, derived.before, strict=True)):
            reads[structure.l_u + j, i] = (now + before * past) * lag
    reads *= sizes[:, None, None]
    information = np.einsum("csw,ctw,wij->sitj", reads.conj(), reads, spectrum, optimize=True).real
    information = information.reshape(structure.l_theta, structure.l_theta)
    information = (information + information.T) / 2
    return np.asarray(information + FLOOR * np.diag(np.diag(information)))
