"""The plant of an experiment file, and how it changes while it runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal

import attrs
from sympy import Expr

import compensator_theory as exact
from compensator_theory.errors import InputError, NotCoprimeError
from compensator_theory.systems._conversions import transfer_function
from compensator_theory.systems._sample_times import agreed_period
from rcac_experiments.format._parts import PartialCall
from rcac_experiments.format._places import Errors, Location
from rcac_experiments.format._signatures import Composed, summary_of
from rcac_experiments.format._tables import (
    Kind,
    Kinds,
    PartialTable,
    Table,
    Variant,
    require_table,
)
from rcac_experiments.format._values import Choice, Exact, Integer, ListOf
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of
from rcac_numeric.arrays._values import replaced
from rcac_numeric.plants._foreign import plant_of
from rcac_numeric.plants._linear import MATRICES, Plant
from rcac_numeric.plants._problems import from_problem, servo_plant, standard_plant
from rcac_numeric.plants._schedules import PlantChange, PlantSchedule
from rcac_numeric.plants.gallery._aircraft import (
    CONDITIONS,
    MEASUREMENTS,
    SOURCES,
    aircraft_plant,
    aircraft_transition,
)
from rcac_numeric.plants.gallery._boost_converter import BoostConverter
from rcac_numeric.plants.gallery._cart_pendulum import CartPendulum
from rcac_numeric.plants.gallery._continuous import ContinuousPlant
from rcac_numeric.plants.gallery._limited_margins import (
    limited_delay_margin,
    no_guaranteed_margins_standard,
)
from rcac_numeric.plants.gallery._mass_spring import MassSpringDamper
from rcac_numeric.plants.gallery._rohrs import rohrs_plant

# A delay is written out as states where the loop is analysed.
LONGEST_DELAY = 200
ENTRIES = ("G", *MATRICES)


def _period(sample_time: Any) -> Expr:
    """A sample time in seconds."""
    if isinstance(sample_time, list):
        raise InputError(f"[plant] sample_time = {sample_time} must be one number, in seconds.")
    period = exact.exact_number(sample_time)
    if not (period.is_Rational and 0 < float(period) < float("inf")):
        raise InputError(f"[plant] sample_time = {sample_time!r} must be positive, in seconds.")
    return period


def _seconds(G: Any, sample_time: Any) -> float:
    """The sample time that a transfer function in s needs."""
    if sample_time is None:
        raise InputError(
            f"[plant] G = {G} is in s, and RCAC runs in discrete time. Add "
            "sample_time, in seconds: it is sampled with a zero-order hold."
        )
    return float(_period(sample_time))


def _timed(plant: Plant, sample_time: Any) -> Plant:
    """The plant with a sample time, of its exact data too."""
    if sample_time is None:
        return plant
    period = _period(sample_time)
    agreed_period(plant.sample_time, float(period), at="the plant", remedy="leave sample_time out.")
    known = None if plant.exact is None else replace(plant.exact, sample_time=period)
    return replaced(plant, exact=known, sample_time=float(period))


def in_time(plant: Plant | PlantSchedule, sample_time: Any = None) -> Plant | PlantSchedule:
    """The plant, and all that it becomes, with a sample time."""
    if isinstance(plant, Plant):
        return _timed(plant, sample_time)
    if sample_time is None:
        return plant
    return PlantSchedule([replaced(c, plant=_timed(c.plant, sample_time)) for c in plant.changes])


OfG = Annotated[
    Any,
    Exact(),
    "In q or z; or in s, and with sample_time, which samples it with a zero-order hold. Of the "
    'servo problem also one row of several, [["G_1", "G_2"]], for a plant with several inputs.',
]
OfState = Annotated[Any, Exact(), "Of x(k+1) = A x + B u + D_1 w."]
OfY = Annotated[
    Any, Exact(), "Of y = C x + D_0 u + D_2 w; D_0 and D_2 are zero where they are left out."
]
OfZ = Annotated[
    Any,
    Exact(),
    "Of z = E_1 x + E_2 u + E_0 w; E_1 is C, E_2 and E_0 are zero where they are left out.",
]
OfServoState = Annotated[Any, Exact(), "Of (2.16); D_1 is B where it is left out."]
OfServoY = Annotated[Any, Exact(), "Of (2.17); D_0 is zero where it is left out."]
Performance = Annotated[
    Literal["measured", "true"],
    "Whether z is e_n, which is measured, or e_0, without the noise v.",
]


def standard_of_G(G: OfG, sample_time: Any = None) -> Plant:
    """The standard problem of a transfer function: y = z and w matched with u, (2.15)."""
    read = transfer_function(G)
    if str(read.variable) == "s":
        plant: Plant = instance_of(plant_of(G, sample_time=_seconds(G, sample_time)), "G", Plant)
        return plant
    _require_coprime(read)
    return _timed(standard_plant(read), sample_time)


def standard_of_matrices(
    A: OfState, B: OfState, D_1: OfState, C: OfY, D_0: OfY = None, D_2: OfY = None,
    E_1: OfZ = None, E_2: OfZ = None, E_0: OfZ = None,
) -> Plant:  # fmt: skip
    """The standard problem (2.1)-(2.3)."""
    E_1 = C if E_1 is None else E_1
    return from_problem(exact.StandardProblem(A, B, C, D_1, D_0, D_2, E_1, E_2, E_0))


def servo_of_G(G: OfG, performance: Performance = "measured", sample_time: Any = None) -> Plant:
    """The servo problem (2.16)-(2.20) of a transfer function, d and u colocated."""
    if isinstance(G, list):  # they say which variable it is where they are read
        return _timed(servo_plant(G, performance=performance), sample_time)
    read = transfer_function(G)
    if str(read.variable) == "s":
        period = _seconds(G, sample_time)
        return servo_plant(plant_of(G, sample_time=period), performance=performance)
    _require_coprime(read)
    return _timed(servo_plant(read, performance=performance), sample_time)


def servo_of_matrices(
    A: OfServoState, B: OfServoState, C: OfServoY, D_1: OfServoState = None, D_0: OfServoY = None,
    performance: Performance = "measured",
) -> Plant:  # fmt: skip
    """The servo problem (2.16)-(2.20), with w = [r; d; v] and y = z = e_n."""
    matrices = {name: m for name, m in (("D_1", D_1), ("D_0", D_0)) if m is not None}
    return servo_plant(A=A, B=B, C=C, performance=performance, **matrices)


# Plants with names.

Period = Annotated[float, "Sampling period, s."]
Loop = Annotated[
    Literal["servo", "standard"],
    "The servo problem (2.16)-(2.27) with d at the input, or y = z with w at the input, (2.15).",
]


def sampled(h: Period, system: ContinuousPlant, loop: Loop = "servo") -> Plant:
    """A plant of the gallery in continuous time, sampled."""
    return system.servo(h) if loop == "servo" else system.sampled(h)


def sampled_delay_limited(h: Period = 0.1, loop: Loop = "servo") -> Plant:
    """The plant (1.3)-(1.4) with a limited delay margin, sampled."""
    return sampled(h, limited_delay_margin(), loop)


def boost_converter(
    duty: Annotated[float, "Duty cycle about which it is linearised."] = 0.5,
    *,
    converter: BoostConverter,
) -> ContinuousPlant:
    """The boost converter near a duty cycle."""
    return converter.linearised(converter.operating_point(duty))


def cart_pendulum(
    kind: Annotated[Literal["upright", "hanging"], "Where the pendulum rests."] = "upright",
    *,
    pendulum: CartPendulum,
) -> ContinuousPlant:
    """The pendulum on a cart at rest."""
    return pendulum.linearised(pendulum.operating_point(kind))


# What a file says otherwise than the library of the parameters of these names.
FORMS = {
    "condition": Choice(CONDITIONS), "measured": Choice(MEASUREMENTS), "source": Choice(SOURCES),
}  # fmt: skip
DOCS = {
    "supply": "Supply voltage, V.",
    **dict.fromkeys(("inductance", "capacitance", "resistance"), "In H, F and ohm."),
    **dict.fromkeys(("cart_mass", "pendulum_mass"), "In kg."),
    "friction": "Of the cart, N s/m.",
    "length": "From the pivot to the centre of mass, m.",
    "inertia": "About the centre of mass, kg m^2.",
    "gravity": "In m/s^2.",
    **dict.fromkeys(("mass", "damping", "stiffness"), "In kg, N s/m and N/m."),
}


def _problem(
    make: Callable[..., Plant | PlantSchedule], words: str = "", **makers: Callable[..., Any]
) -> Table[Plant | PlantSchedule]:
    """The table of a function that makes a plant, which [plant] gives a sample time."""
    whole = Composed(in_time, words or summary_of(make), plant=make, **makers)
    return Table(whole, supplied=["sample_time"], forms=FORMS, docs=DOCS)


PROBLEMS: Kinds[Plant | PlantSchedule] = Kinds(
    {
        "standard": Kind(
            Variant(Table(standard_of_G, supplied=["sample_time"]), "G"),
            Variant(_problem(standard_of_matrices)),
        ),
        "servo": Kind(
            Variant(Table(servo_of_G, supplied=["sample_time"]), "G"),
            Variant(_problem(servo_of_matrices)),
        ),
        "aircraft": _problem(aircraft_plant),
        "aircraft transition": _problem(aircraft_transition),
        "boost converter": _problem(
            sampled,
            "The boost converter near a duty cycle, from duty cycle to output voltage.",
            system=boost_converter,
            converter=BoostConverter,
        ),
        "cart pendulum": _problem(
            sampled,
            "The pendulum on a cart at rest, from force to position.",
            system=cart_pendulum,
            pendulum=CartPendulum,
        ),
        "limited delay margin": _problem(sampled_delay_limited),
        "mass-spring-damper": _problem(
            sampled,
            "The mass-spring-damper of (8.64), from force to velocity, by a zero-order hold.",
            system=MassSpringDamper.continuous,
            self=MassSpringDamper,
        ),
        "no guaranteed margins": _problem(no_guaranteed_margins_standard),
        "rohrs": _problem(sampled, "Rohrs's plant T(s) of (1.7), sampled.", system=rohrs_plant),
    }
)
NewMatrix = Annotated[
    Any, Exact(), "The new ones. The state is kept, so that C and E_1 alone move the zeros."
]


@attrs.frozen(eq=False)
class Change:
    """The plant from a step on; keys that it leaves out keep their values."""

    start: Annotated[
        int,
        "The step; a change at step 0 says what holds from the beginning, such as a delay.",
    ]
    gain: Annotated[
        Any,
        Exact(),
        "u acts this many times as strongly as B and the direct terms of [plant] say.",
    ] = None
    delay: Annotated[
        int | None,
        Integer(at_most=LONGEST_DELAY),
        "u acts this many steps late; what was sent before the change is kept.",
    ] = None
    ramp: Annotated[
        bool,
        "The matrices move linearly and reach those of the next change at its start.",
    ] = False
    state_map: Annotated[
        Array | None,
        "x <- state_map x at `start`; needed where the order changes.",
    ] = None
    G: Annotated[Any, Exact(), "The new plant."] = None
    A: NewMatrix = None
    B: NewMatrix = None
    C: NewMatrix = None
    D_0: NewMatrix = None
    D_1: NewMatrix = None
    D_2: NewMatrix = None
    E_0: NewMatrix = None
    E_1: NewMatrix = None
    E_2: NewMatrix = None


CHANGE = Table(Change)


def _plant(
    problem: Annotated[
        PartialCall[Any],
        PROBLEMS,
        "Which problem the transfer function or the matrices are of, or a plant by its name.",
    ],
    changes: Annotated[
        list[Change] | None, ListOf(CHANGE), "How the plant changes while it runs."
    ] = None,
    sample_time: Annotated[
        Any,
        Exact(),
        "One step in seconds: reports give times too, and controllers go out with it. A plant in s "
        "is sampled with it.",
    ] = None,
) -> PartialCall[Plant | PlantSchedule]:
    """A plant."""
    return PartialCall(problem.make, {**problem.arguments, "sample_time": sample_time})


PLANT = PartialTable(Table(_plant), is_replaced=True)


def changing(
    first: Plant | PlantSchedule, changes: Sequence[tuple[Change, Plant | PlantSchedule]]
) -> PlantSchedule:
    """Return the schedule of a plant and its changes, each with the resulting plant."""
    parts = [PlantChange(start=0, plant=_unchanging(first))]
    gain, delay = 1, 0
    for index, (change, plant) in enumerate(changes):
        gain = gain if change.gain is None else change.gain
        delay = delay if change.delay is None else change.delay
        if index == 0 and change.start == 0:
            parts = []  # a change at step 0 replaces the first plant
        parts.append(
            PlantChange(
                start=change.start,
                plant=_amplified(_unchanging(plant), gain),
                ramp=change.ramp,
                state_map=change.state_map,
                delay=delay,
            )
        )
    return PlantSchedule(parts)


def read_plant(value: object, place: Location) -> PartialCall[Plant | PlantSchedule]:
    """What [plant] says; a change takes what it does not name from what is before it."""
    table = require_table(value, place)
    entries = {key: entry for key, entry in table.items() if key != "changes"}
    first: PartialCall[Plant | PlantSchedule] = PLANT.table.read(entries, place)
    if "changes" not in table:
        return first
    changes, errors = [], Errors()
    read = ListOf(CHANGE).read(table["changes"], place.at("changes"))
    for number, (change, entry) in enumerate(zip(read, table["changes"], strict=True), 1):
        matrices = {key: value for key, value in entry.items() if key in ENTRIES}
        if "G" in matrices or ("G" in entries and matrices):
            entries = {key: value for key, value in entries.items() if key not in ENTRIES}
        entries = {**entries, **matrices}
        location = place.at("changes").entry(f"no. {number}").inside()
        with errors:
            changes.append((change, PLANT.table.read(entries, location)))
    errors.raise_any()
    return PartialCall(changing, {"first": first, "changes": tuple(changes)})


def _unchanging(plant: Plant | PlantSchedule) -> Plant:
    if isinstance(plant, PlantSchedule):
        raise InputError(
            "[plant] changes: this plant has its own changes. Remove changes, or use a plant "
            'that does not, such as problem = "aircraft".'
        )
    return plant


def _amplified(plant: Plant, gain: Any) -> Plant:
    """The plant whose control input acts `gain` times as strongly."""
    if gain == 1:
        return plant
    factor = exact.exact_number(gain)
    if not (factor.is_number and factor.is_real):
        raise InputError(f"gain = {gain!r} must be a real number.")
    problem = plant.problem
    scaled = {name: factor * getattr(problem, name) for name in ("B", "D_0", "E_2")}
    scaled_plant = from_problem(replace(problem, **scaled), plant.blocks)
    return replaced(scaled_plant, sample_time=plant.sample_time)


def _require_coprime(plant: exact.TransferFunction) -> None:
    if plant.is_coprime is False:
        raise NotCoprimeError(
            "numerator and denominator of the plant G share the factor "
            f"{plant.common_factor().as_expr()}: no controller moves that pole. Cancel the factor, "
            "or give the matrices A, B, D_1 and C to keep the hidden mode."
        )
