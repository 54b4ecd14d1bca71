"""The controller of an experiment file: RCAC, several of them, LQG's or PCAC."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, cast

import attrs

from compensator_theory.errors import InputError
from rcac_experiments.files._structures import STRUCTURES
from rcac_experiments.files._targets import TARGET
from rcac_experiments.files._updates import UPDATES
from rcac_experiments.format._parts import PartialCall
from rcac_experiments.format._places import Errors, Location
from rcac_experiments.format._tables import (
    Kind,
    Kinds,
    PartialTable,
    Raw,
    Table,
    Variant,
    keys_of,
)
from rcac_experiments.format._values import (
    ByStep,
    Either,
    Form,
    Integer,
    ListOf,
    MapOf,
    Numbers,
    Real,
    Row,
    Schema,
)
from rcac_numeric.analysis._lqg import lqg_controller
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._bounds import CertifiedBounds, CoefficientBounds
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._decentralized import Decentralized
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._limits import ControlLimits
from rcac_numeric.controllers._normalization import Normalization
from rcac_numeric.controllers._predictive_cost import PredictiveCost
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._weights import SignalWeight
from rcac_numeric.engine._compatibility import AnyController
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule
from rcac_numeric.targets._data_driven import DataDriven
from rcac_numeric.targets._model import TargetModel


class _Interval(Form):
    """Steps without update."""

    words = "[start, stop] or [start]"

    def read(self, value: object, place: Location) -> tuple[int, int | None]:
        """Return (start, stop), with None for an open end."""
        start, *stop = Row((Integer(), Integer()), self.words, at_least=1).read(value, place)
        return start, stop[0] if stop else None

    def schema(self) -> Schema:
        """One number or two."""
        return Row((Integer(), Integer()), self.words, at_least=1).schema()


NOISE = MapOf(Numbers())
BOUND = Row((Real(), Real()), "[low, high]")
BOX = Table(CoefficientBounds, forms={"gains": MapOf(BOUND)})
ELLIPSOID = Table(CertifiedBounds)


class _Bounds(Form):
    """A box, or an ellipsoid where a center or a factor stands in the table."""

    words = f"{BOX.words}; or {ELLIPSOID.words}"

    def read(self, value: object, place: Location) -> CoefficientBounds | CertifiedBounds:
        """By the keys."""
        is_ellipsoid = isinstance(value, Mapping) and not {"center", "factor"}.isdisjoint(value)
        return cast(
            CoefficientBounds | CertifiedBounds,
            (ELLIPSOID if is_ellipsoid else BOX).read(value, place),
        )

    def schema(self) -> Schema:
        """Either."""
        return {"anyOf": [BOX.schema(), ELLIPSOID.schema()]}


def lqg_alone(
    plant: Plant | PlantSchedule,
    form: Annotated[
        Literal["predictor", "filter"],
        "Whether u(k) uses y(k-1) at the latest, or y(k) too.",
    ] = "predictor",
    noise: Annotated[
        dict[str, Any] | None,
        NOISE,
        "Intensities by block or channel of w, `{ d = 1, v = 0.25 }`; 1 for every channel where "
        "it is left out.",
    ] = None,
    k_w: Annotated[int, "First step at which it is in the loop."] = 0,
    target: object = None,
) -> FixedController:
    """The [LQG](lqg.md) controller of the plant, which adapts nothing."""
    if isinstance(plant, PlantSchedule):
        raise InputError('structure = "lqg" is designed for one plant; this one changes.')
    return FixedController(lqg_controller(plant, noise=noise, form=form).compensator, k_w=k_w)


def predictive_cost(
    plant: Plant | PlantSchedule,
    order: int,
    horizon: int,
    Q: Array = 1.0,  # type: ignore[assignment]
    P: Array = 1.0,  # type: ignore[assignment]
    R: Array = 1.0,  # type: ignore[assignment]
    weighs: Literal["moves", "u"] = "moves",
    problem: Literal["standard", "servo", "tracking"] = "standard",
    R_theta: float = 1e-3,
    lambda_: float = 1.0,
    theta_0: Array = 0.01,  # type: ignore[assignment]
    limits: ControlLimits | None = None,
    limited_by: Literal["saturation", "least squares"] = "saturation",
    target: object = None,
) -> PredictiveCost:
    """[Predictive cost adaptive control](guide/predictive-cost.md), which needs no target model."""
    return PredictiveCost(
        order, horizon, Q=Q, P=P, R=R, weighs=weighs, problem=problem, R_theta=R_theta,
        lambda_=lambda_, theta_0=theta_0, limits=limits, limited_by=limited_by, l_u=plant.l_u,
        l_y=plant.l_y,
    )  # fmt: skip


PREDICTIVE_COST = Table(
    predictive_cost,
    supplied=["plant", "target"],
    forms={"R_theta": Numbers()},  # as that of an update, so that the table has one R_theta
    docs={key.parameter: key.doc for key in keys_of(PredictiveCost)},
)
# In place of a structure: the whole table is then of another controller than RCAC.
WHOLE: dict[str, Kind[Any]] = {
    "lqg": Kind(Variant(Table(lqg_alone, supplied=["plant", "target"])), is_whole=True),
    "predictive cost": Kind(Variant(PREDICTIVE_COST), is_whole=True),
}
WITHOUT_TARGET = "predictive cost"
STRUCTURES_AND_WHOLE: Kinds[Any] = Kinds({**STRUCTURES.kinds, **WHOLE}, default=STRUCTURES.default)


WEIGHT = Either(Table(SignalWeight), Numbers())
FORMS: Mapping[str, Form] = {
    "structure": STRUCTURES_AND_WHOLE,
    "update": UPDATES,
    "R_z": WEIGHT,
    "R_u": WEIGHT,
    "R_u_unfiltered": Numbers(),
    "z_normalization": Table(Normalization),
    "bounds": _Bounds(),
    "fixed": Table(Compensator, supplied=["sample_time"]),
    "theta_0": Numbers(),
    "k_w": Integer(),
    "k_update": Integer(),
    "target_changes": ByStep(TARGET.table),
    "freeze": ListOf(_Interval()),
}
DOCS = {
    "structure": "The structure, which defines the regressor.",
    "update": "How theta is adapted; as `arithmetic` in [run] where it is left out.",
    "R_z": "Weights of (2.41): numbers, matrices, or `{ z_squared = c, constant = b, nu = a }` "
    "for (b + c z'z)/(1 + a |z|)^2 I.",
    "z_normalization": "f(z) instead of z in the cost: `{ limit = 5 }`.",
    "bounds": "Of theta: `{ low = 0, high = 5, gains = { K_D = [0, 1] } }`, or an ellipsoid, "
    "`{ center = [1, 2], factor = [[0.1, 0], [0, 0.2]] }`.",
    "fixed": "A compensator in parallel: `{ past_u = [[[1]]], past_y = [[[0]], [[0.5]]] }`.",
    "R_u": "Likewise.",
    "target_changes": "`[[step, { model = ... }], ...]`: G_f from that step on.",
    "freeze": "`[[start, stop], ...]` without update; `[start]` alone: to the end.",
}


def _several(
    shared_u: Annotated[
        bool,
        "Of [[controllers]]: every regressor holds the sum of all outputs, not its controller's; "
        "with saturation that is needed.",
    ] = False,
) -> bool:
    """The common options of several controllers."""
    return shared_u


SEVERAL = Table(_several)
CONTROLLER = PartialTable(
    Table(
        ControllerSettings,
        supplied=["target", "learning"],
        forms=FORMS,
        docs=DOCS,
        elsewhere=(SEVERAL, "only [[controllers]] read"),
        is_later=True,
    )
)
ONE_OF_SEVERAL = PartialTable(
    Table(
        ControllerSettings,
        supplied=["learning"],
        forms={**FORMS, "structure": STRUCTURES, "target": TARGET},
        docs={**DOCS, "target": "A separate target model, or its differences from [target]."},
        is_later=True,
    )
)


@attrs.frozen(eq=False)
class ControllerSpecification(Value):
    """The controllers of a run, and the target model of one alone."""

    parts: tuple[PartialCall[AnyController], ...]
    target: PartialCall[TargetModel | DataDriven] | None
    shared_u: bool = False
    is_decentralized: bool = False

    def build(
        self, plant: Plant | PlantSchedule, target: TargetModel | DataDriven | None = None
    ) -> tuple[AnyController, TargetModel | None]:
        """The controller, and the target model that it does not hold itself.

        A target model takes the plant's parameters at step 0; `target` is
        what its table makes of this plant, where that is known.
        """
        if self.is_decentralized:
            settings: list[Any] = [part.of(plant) for part in self.parts]
            return Decentralized(settings, shared_u=self.shared_u), None
        if target is None and self.target is not None:
            target = self.target.of(plant)
        controller = self.parts[0].of(plant, target=target)
        has_none = isinstance(controller, FixedController | PredictiveCost)
        return controller, target if has_none else None  # type: ignore[return-value]


NO_TARGET = (
    "the table [target], the target model of RCAC, is missing. Add for instance\n\n"
    '[target]\nmodel = "pole placement"\npoles = ["0.5"]'
)


def read_controllers(
    common: Raw, target: Raw, several: list[Raw], place: Callable[[str], Location]
) -> ControllerSpecification:
    """The settings of [controller], [target] and [[controllers]].

    Each of several takes from [controller] and [target] what it does not say itself. `place` says
    where the table of a name stands.
    """
    location = place("controller")
    if not several:
        if not target and common.get("structure") != WITHOUT_TARGET:
            raise InputError(NO_TARGET)
        errors, of_target = Errors(), None
        read: tuple[Any, ...] = ()
        with errors:
            of_target = None if not target else TARGET.table.read(target, place("target"))
        with errors:
            read = (CONTROLLER.table.read(common, location),)
        errors.raise_any()
        return ControllerSpecification(read, of_target)
    shared = {key.name for key in SEVERAL.keys}
    shared_u: bool = SEVERAL.read({k: v for k, v in common.items() if k in shared}, location)
    base = {key: value for key, value in common.items() if key not in shared}
    parts, errors = [], Errors()
    for number, entry in enumerate(several, 1):
        joined = ONE_OF_SEVERAL.joined(base, entry)
        there = place("controllers")
        run = there.notes or location.notes or place("target").notes
        there = replace(there, notes=(f"no. {number}", *run))
        joined_target = TARGET.joined(target, joined.pop("target", {}))
        with errors:
            part = ONE_OF_SEVERAL.table.read({**joined, "target": {}}, there)
            part.arguments["target"] = TARGET.table.read(joined_target, there.at("target").inside())
            parts.append(part)
    errors.raise_any()
    return ControllerSpecification(tuple(parts), None, shared_u, is_decentralized=True)
