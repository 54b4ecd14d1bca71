"""The plant of an experiment file, and how it changes while it runs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Annotated, Any, Literal

import attrs
from sympy import Expr

import compensator_theory as exact
from compensator_theory.errors import InputError, NotCoprimeError
from compensator_theory.systems._sample_times import agreed_period
from rcac_experiments.format._places import Errors, Place
from rcac_experiments.format._tables import (
    Deferred,
    Kind,
    Kinds,
    Table,
    Variant,
    require_table,
)
from rcac_experiments.format._values import Exact, Integer, ListOf
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of
from rcac_numeric.arrays._values import replaced
from rcac_numeric.plants._foreign import plant_of
from rcac_numeric.plants._linear import MATRICES, Plant
from rcac_numeric.plants._problems import from_problem, servo_plant, standard_plant
from rcac_numeric.plants._schedules import PlantChange, PlantSchedule
from rcac_numeric.plants.gallery._aircraft import aircraft_plant, aircraft_transition
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
Entry = Annotated[Any, Exact()]


class PlantKind(ABC):
    """A plant, by its transfer function, its matrices or its name."""

    @abstractmethod
    def made(self) -> Plant | PlantSchedule:
        """The plant."""


TRANSFER_FUNCTION = (
    "In q or z; or in s, and with sample_time, which samples it with a zero-order hold. Of the "
    'servo problem also one row of several, [["G_1", "G_2"]], for a plant with several inputs.'
)
OF_STATE = "Of x(k+1) = A x + B u + D_1 w."
OF_Y = "Of y = C x + D_0 u + D_2 w; D_0 and D_2 are zero where they are left out."
OF_Z = "Of z = E_1 x + E_2 u + E_0 w; E_1 is C, E_2 and E_0 are zero where they are left out."
OF_SERVO_STATE = "Of (2.16); D_1 is B where it is left out."
OF_SERVO_Y = "Of (2.17); D_0 is zero where it is left out."
PERFORMANCE = "Whether z is e_n, which is measured, or e_0, without the noise v."


@attrs.frozen(eq=False)
class StandardOfG(PlantKind):
    """The standard problem of a transfer function: y = z and w matched with u, (2.15)."""

    G: Annotated[Entry, TRANSFER_FUNCTION]

    def made(self) -> Plant:
        """The plant."""
        _require_coprime(self.G)
        return standard_plant(self.G)

    def sampled(self, period: float) -> Plant:
        """The plant, where G is in s."""
        plant: Plant = instance_of(plant_of(self.G, sample_time=period), "G", Plant)
        return plant


@attrs.frozen(eq=False)
class Standard(PlantKind):
    """The standard problem (2.1)-(2.3)."""

    A: Annotated[Entry, OF_STATE]
    B: Annotated[Entry, OF_STATE]
    D_1: Annotated[Entry, OF_STATE]
    C: Annotated[Entry, OF_Y]
    D_0: Annotated[Entry, OF_Y] = None
    D_2: Annotated[Entry, OF_Y] = None
    E_1: Annotated[Entry, OF_Z] = None
    E_2: Annotated[Entry, OF_Z] = None
    E_0: Annotated[Entry, OF_Z] = None

    def made(self) -> Plant:
        """The plant."""
        matrices = attrs.asdict(self, recurse=False)
        matrices["E_1"] = self.C if self.E_1 is None else self.E_1
        return from_problem(exact.StandardProblem(**matrices))


@attrs.frozen(eq=False)
class ServoOfG(PlantKind):
    """The servo problem (2.16)-(2.20) of a transfer function, d and u colocated."""

    G: Annotated[Entry, TRANSFER_FUNCTION]
    performance: Annotated[Literal["measured", "true"], PERFORMANCE] = "measured"

    def made(self) -> Plant:
        """The plant."""
        if not isinstance(self.G, list):
            _require_coprime(self.G)
        return servo_plant(self.G, performance=self.performance)

    def sampled(self, period: float) -> Plant:
        """The plant, where G is in s."""
        return servo_plant(plant_of(self.G, sample_time=period), performance=self.performance)


@attrs.frozen(eq=False)
class Servo(PlantKind):
    """The servo problem (2.16)-(2.20), with w = [r; d; v] and y = z = e_n."""

    A: Annotated[Entry, OF_SERVO_STATE]
    B: Annotated[Entry, OF_SERVO_STATE]
    C: Annotated[Entry, OF_SERVO_Y]
    D_1: Annotated[Entry, OF_SERVO_STATE] = None
    D_0: Annotated[Entry, OF_SERVO_Y] = None
    performance: Annotated[Literal["measured", "true"], PERFORMANCE] = "measured"

    def made(self) -> Plant:
        """The plant."""
        given = {name: m for name in ("D_1", "D_0") if (m := getattr(self, name)) is not None}
        return servo_plant(A=self.A, B=self.B, C=self.C, performance=self.performance, **given)


# Plants with names.
CONDITION = "(3.1) or (3.2)."
MEASURED = (
    "y = z = r - phi; r - x with four commands; or, with one command for the roll angle, "
    "(3.5)-(3.7): z_i(k) = x_i(k-1) - x_i(k) for the other three states, which become states."
)
SOURCE = "The zero-order hold rounded once; (3.3), (3.4) with two digits put right; or as printed."
TIMES = (
    "In s, multiples of 0.1 s; the text has 250 s and 10 s, and 1 s where it discusses figure 3.9."
)
PERIOD = "Sampling period, s."
LOOP = "The servo problem (2.16)-(2.27) with d at the input, or y = z with w at the input, (2.15)."
Measured = Literal["roll angle", "state", "dummy commands"]
Source = Literal["sampled", "corrected", "printed"]
Loop = Literal["servo", "standard"]


@attrs.frozen
class Aircraft(PlantKind):
    """The servo problem of the aircraft at 0.1 s: output feedback or full-state feedback."""

    condition: Annotated[Literal["nominal", "off-nominal"], CONDITION] = "nominal"
    measured: Annotated[Measured, MEASURED] = "roll angle"
    source: Annotated[Source, SOURCE] = "sampled"

    def made(self) -> Plant:
        """The plant."""
        return aircraft_plant(self.condition, self.measured, self.source)


@attrs.frozen
class AircraftTransition(PlantKind):
    """The aircraft on its way from nominal to off-nominal, section 3.2."""

    start: Annotated[float, TIMES] = 250.0
    duration: Annotated[float, TIMES] = 10.0
    measured: Annotated[Measured, MEASURED] = "roll angle"
    source: Annotated[Source, SOURCE] = "sampled"

    def made(self) -> PlantSchedule:
        """The plant."""
        return aircraft_transition(self.start, self.duration, self.measured, self.source)


OF_BOOST = "In H, F and ohm."


@attrs.frozen
class SampledBoostConverter(PlantKind):
    """The boost converter near a duty cycle, from duty cycle to output voltage."""

    h: Annotated[float, PERIOD]
    duty: Annotated[float, "Duty cycle about which it is linearised."] = 0.5
    supply: Annotated[float, "Supply voltage, V."] = 12.0
    inductance: Annotated[float, OF_BOOST] = 1e-4
    capacitance: Annotated[float, OF_BOOST] = 1e-4
    resistance: Annotated[float, OF_BOOST] = 10.0
    loop: Annotated[Loop, LOOP] = "servo"

    def made(self) -> Plant:
        """The plant."""
        plant = BoostConverter(self.supply, self.inductance, self.capacitance, self.resistance)
        return _in_loop(plant.linearised(plant.operating_point(self.duty)), self.h, self.loop)


OF_MASS = "In kg."


@attrs.frozen
class SampledCartPendulum(PlantKind):
    """The pendulum on a cart at rest, from force to position."""

    h: Annotated[float, PERIOD]
    kind: Annotated[Literal["upright", "hanging"], "Where the pendulum rests."] = "upright"
    cart_mass: Annotated[float, OF_MASS] = 0.5
    pendulum_mass: Annotated[float, OF_MASS] = 0.2
    friction: Annotated[float, "Of the cart, N s/m."] = 0.1
    length: Annotated[float, "From the pivot to the centre of mass, m."] = 0.3
    inertia: Annotated[float, "About the centre of mass, kg m^2."] = 0.006
    gravity: Annotated[float, "In m/s^2."] = 9.8
    loop: Annotated[Loop, LOOP] = "servo"

    def made(self) -> Plant:
        """The plant."""
        plant = CartPendulum(
            self.cart_mass, self.pendulum_mass, self.friction, self.length, self.inertia,
            self.gravity,
        )  # fmt: skip
        return _in_loop(plant.linearised(plant.operating_point(self.kind)), self.h, self.loop)


@attrs.frozen
class SampledDelayLimited(PlantKind):
    """The plant (1.3)-(1.4) with a limited delay margin, sampled."""

    h: Annotated[float, PERIOD] = 0.1
    loop: Annotated[Loop, LOOP] = "servo"

    def made(self) -> Plant:
        """The plant."""
        return _in_loop(limited_delay_margin(), self.h, self.loop)


OF_MASS_SPRING = "In kg, N s/m and N/m."


@attrs.frozen
class SampledMassSpringDamper(PlantKind):
    """The mass-spring-damper of (8.64), from force to velocity, by a zero-order hold."""

    h: Annotated[float, PERIOD]
    mass: Annotated[float, OF_MASS_SPRING] = 1.0
    damping: Annotated[float, OF_MASS_SPRING] = 5.0
    stiffness: Annotated[float, OF_MASS_SPRING] = 10.0
    loop: Annotated[Loop, LOOP] = "servo"

    def made(self) -> Plant:
        """The plant."""
        plant = MassSpringDamper(self.mass, self.damping, self.stiffness)
        return _in_loop(plant.continuous(), self.h, self.loop)


@attrs.frozen
class NoGuaranteedMargins(PlantKind):
    """The standard problem of (1.1)-(1.2), sampled; section 5.5 has h = 0.01 s."""

    h: Annotated[float, PERIOD] = 0.01

    def made(self) -> Plant:
        """The plant."""
        return no_guaranteed_margins_standard(self.h)


@attrs.frozen
class SampledRohrs(PlantKind):
    """Rohrs's plant T(s) of (1.7), sampled."""

    h: Annotated[float, PERIOD]
    loop: Annotated[Loop, LOOP] = "servo"

    def made(self) -> Plant:
        """The plant."""
        return _in_loop(rohrs_plant(), self.h, self.loop)


PROBLEMS: Kinds[PlantKind] = Kinds(
    {
        "standard": Kind(Variant(StandardOfG, "G"), Variant(Standard)),
        "servo": Kind(Variant(ServoOfG, "G"), Variant(Servo)),
        "aircraft": Aircraft,
        "aircraft transition": AircraftTransition,
        "boost converter": SampledBoostConverter,
        "cart pendulum": SampledCartPendulum,
        "limited delay margin": SampledDelayLimited,
        "mass-spring-damper": SampledMassSpringDamper,
        "no guaranteed margins": NoGuaranteedMargins,
        "rohrs": SampledRohrs,
    }
)
NEW_MATRIX = "The new ones. The state is kept, so that C and E_1 alone move the zeros."


@attrs.frozen(eq=False)
class Change:
    """What the plant is from a step on; what is not named stays as it was."""

    start: Annotated[
        int,
        "The step; a change at step 0 says what holds from the beginning, such as a delay.",
    ]
    gain: Annotated[
        Entry,
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
    G: Annotated[Entry, "The new plant."] = None
    A: Annotated[Entry, NEW_MATRIX] = None
    B: Annotated[Entry, NEW_MATRIX] = None
    C: Annotated[Entry, NEW_MATRIX] = None
    D_0: Annotated[Entry, NEW_MATRIX] = None
    D_1: Annotated[Entry, NEW_MATRIX] = None
    D_2: Annotated[Entry, NEW_MATRIX] = None
    E_0: Annotated[Entry, NEW_MATRIX] = None
    E_1: Annotated[Entry, NEW_MATRIX] = None
    E_2: Annotated[Entry, NEW_MATRIX] = None


CHANGE = Table(Change)


@attrs.frozen(eq=False)
class PlantTable:
    """A plant."""

    problem: Annotated[
        PlantKind,
        PROBLEMS,
        "Which problem the transfer function or the matrices are of, or a plant by its name.",
    ]
    changes: Annotated[
        list[Change] | None,
        ListOf(CHANGE),
        "How the plant changes while it runs.",
    ] = None
    sample_time: Annotated[
        Entry,
        "One step in seconds: reports give times too, and controllers go out with it. A plant in s "
        "is sampled with it.",
    ] = None

    def made(self) -> Plant | PlantSchedule:
        """The plant, its changes left out."""
        problem = self.problem
        if isinstance(problem, StandardOfG | ServoOfG) and _is_continuous(problem.G):
            if self.sample_time is None:
                raise InputError(
                    f"[plant] G = {problem.G} is in s, and RCAC runs in discrete time. Add "
                    "sample_time, in seconds: it is sampled with a zero-order hold."
                )
            return problem.sampled(float(_period(self.sample_time)))
        plant = problem.made()
        if self.sample_time is None:
            return plant
        if isinstance(plant, PlantSchedule):
            changed = [replaced(c, plant=_timed(c.plant, self.sample_time)) for c in plant.changes]
            return PlantSchedule(changed)
        return _timed(plant, self.sample_time)


PLANT = Deferred(Table(PlantTable), is_replaced=True)


@attrs.frozen(eq=False)
class PlantSpecification:
    """A plant and what becomes of it, each change with the plant that it leads to."""

    first: PlantTable
    changes: tuple[tuple[Change, PlantTable], ...] | None

    def build(self) -> Plant | PlantSchedule:
        """The plant; with changes a schedule, each of them going on from the one before."""
        if self.changes is None:
            return self.first.made()
        made = [PlantChange(start=0, plant=_unchanging(self.first.made()))]
        gain, delay = 1, 0
        for index, (change, table) in enumerate(self.changes):
            gain = gain if change.gain is None else change.gain
            delay = delay if change.delay is None else change.delay
            if index == 0 and change.start == 0:
                made = []  # what the file says of step 0 itself
            made.append(
                PlantChange(
                    start=change.start,
                    plant=_amplified(_unchanging(table.made()), gain),
                    ramp=change.ramp,
                    state_map=change.state_map,
                    delay=delay,
                )
            )
        return PlantSchedule(made)


def read_plant(value: object, place: Place) -> PlantSpecification:
    """What [plant] says; a change takes what it does not name from what is before it."""
    table = require_table(value, place)
    own = {key: entry for key, entry in table.items() if key != "changes"}
    first: PlantTable = PLANT.table.read(own, place)
    if "changes" not in table:
        return PlantSpecification(first, None)
    changes, errors = [], Errors()
    read = ListOf(CHANGE).read(table["changes"], place.at("changes"))
    for number, (change, entry) in enumerate(zip(read, table["changes"], strict=True), 1):
        given = {key: value for key, value in entry.items() if key in ENTRIES}
        if "G" in given or ("G" in own and given):
            own = {key: value for key, value in own.items() if key not in ENTRIES}
        own = {**own, **given}
        here = place.at("changes").entry(f"no. {number}").inside()
        with errors:
            changes.append((change, PLANT.table.read(own, here)))
    errors.raise_any()
    return PlantSpecification(first, tuple(changes))


def _in_loop(plant: ContinuousPlant, h: float, loop: Loop) -> Plant:
    return plant.servo(h) if loop == "servo" else plant.sampled(h)


def _period(sample_time: Any) -> Expr:
    """A sample time in seconds."""
    if isinstance(sample_time, list):
        raise InputError(f"[plant] sample_time = {sample_time} must be one number, in seconds.")
    period = exact.exact_number(sample_time)
    if not (period.is_Rational and 0 < float(period) < float("inf")):
        raise InputError(f"[plant] sample_time = {sample_time!r} must be positive, in seconds.")
    return period


def _timed(plant: Plant, sample_time: Any) -> Plant:
    """The plant with a sample time, of its exact data too."""
    period = _period(sample_time)
    agreed_period(plant.sample_time, float(period), at="the plant", remedy="leave sample_time out.")
    known = None if plant.exact is None else replace(plant.exact, sample_time=period)
    return replaced(plant, exact=known, sample_time=float(period))


def _unchanging(plant: Plant | PlantSchedule) -> Plant:
    if isinstance(plant, PlantSchedule):
        raise InputError(
            "[plant] changes: this plant changes by itself. Leave changes out, or take a plant "
            'that does not, such as problem = "aircraft".'
        )
    return plant


def _amplified(plant: Plant, gain: Any) -> Plant:
    """The plant whose control input acts `gain` times as strongly."""
    if gain == 1:
        return plant
    factor = exact.exact_number(gain)
    if not (factor.is_number and factor.is_real):
        raise InputError(f"gain = {gain!r} is not a real number.")
    problem = plant.problem
    scaled = {name: factor * getattr(problem, name) for name in ("B", "D_0", "E_2")}
    made = from_problem(replace(problem, **scaled), plant.blocks)
    return replaced(made, sample_time=plant.sample_time)


def _is_continuous(G: Any) -> bool:
    """Whether a transfer function is in s; rows of several say it where they are read."""
    return not isinstance(G, list) and str(exact.transfer_function(G).variable) == "s"


def _require_coprime(G: Any) -> None:
    plant = exact.transfer_function(G)
    if plant.is_coprime is False:
        raise NotCoprimeError(
            "numerator and denominator of the plant G share the factor "
            f"{plant.common_factor().as_expr()}: no controller moves that pole. Cancel the factor, "
            "or give the matrices A, B, D_1 and C if the hidden mode is meant."
        )
