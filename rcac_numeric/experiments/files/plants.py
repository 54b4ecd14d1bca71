"""The plant of an experiment file, and how it changes while it runs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import compensator_theory as exact
from compensator_theory.errors import InputError, NotCoprimeError
from rcac_numeric.experiments.format.deferred import Deferred
from rcac_numeric.experiments.format.lists import ListOf
from rcac_numeric.experiments.format.parts import Part
from rcac_numeric.experiments.format.places import Place
from rcac_numeric.experiments.format.tables import Kind, Kinds, Table, Variant, require_table
from rcac_numeric.experiments.format.values import Exact, Flag, Integer, Numbers
from rcac_numeric.plants.gallery import by_name
from rcac_numeric.plants.gallery.aircraft import aircraft_plant, aircraft_transition
from rcac_numeric.plants.gallery.limited_margins import no_guaranteed_margins_standard
from rcac_numeric.plants.linear import MATRICES, Plant
from rcac_numeric.plants.problems import from_problem, servo_plant, standard_plant
from rcac_numeric.plants.schedules import PlantChange, PlantSchedule

# A delay is written out as states where the loop is analysed.
LONGEST_DELAY = 200
ENTRIES = {name: Exact() for name in ("G", *MATRICES)}


def _standard_of_G(G: Any) -> Plant:
    """The standard problem of a transfer function: y = z and w matched with u, (2.15).

    Parameters
    ----------
    G : transfer function
        In q. Of the servo problem also one row of several, [["G_1", "G_2"]], for a plant with
        several inputs.
    """
    _require_coprime(G)
    return standard_plant(G)


def _standard(
    A: Any, B: Any, D_1: Any, C: Any, D_0: Any = None, D_2: Any = None, E_1: Any = None,
    E_2: Any = None, E_0: Any = None,
) -> Plant:  # fmt: skip
    """The standard problem (2.1)-(2.3).

    Parameters
    ----------
    A, B, D_1 : matrices
        Of x(k+1) = A x + B u + D_1 w.
    C, D_0, D_2 : matrices
        Of y = C x + D_0 u + D_2 w; D_0 and D_2 are zero where they are left out.
    E_1, E_2, E_0 : matrices
        Of z = E_1 x + E_2 u + E_0 w; E_1 is C, E_2 and E_0 are zero where they are left out.
    """
    matrices = {"D_0": D_0, "D_2": D_2, "E_1": C if E_1 is None else E_1, "E_2": E_2, "E_0": E_0}
    return from_problem(exact.StandardProblem(A=A, B=B, D_1=D_1, C=C, **matrices))


def _servo_of_G(G: Any, performance: str = "measured") -> Plant:
    """The servo problem (2.16)-(2.20) of a transfer function, d and u colocated.

    Parameters
    ----------
    G : transfer function
        In q. Of the servo problem also one row of several, [["G_1", "G_2"]], for a plant with
        several inputs.
    performance : {"measured", "true"}
        Whether z is e_n, which is measured, or e_0, without the noise v.
    """
    if not isinstance(G, list):
        _require_coprime(G)
    return servo_plant(G, performance=performance)


def _servo(
    A: Any, B: Any, C: Any, D_1: Any = None, D_0: Any = None, performance: str = "measured"
) -> Plant:
    """The servo problem (2.16)-(2.20), with w = [r; d; v] and y = z = e_n.

    Parameters
    ----------
    A, B, D_1 : matrices
        Of (2.16); D_1 is B where it is left out.
    C, D_0 : matrices
        Of (2.17); D_0 is zero where it is left out.
    performance : {"measured", "true"}
        As with G.
    """
    matrices = {k: v for k, v in (("D_1", D_1), ("D_0", D_0)) if v is not None}
    return servo_plant(A=A, B=B, C=C, performance=performance, **matrices)


PROBLEMS: Kinds[Plant | PlantSchedule] = Kinds(
    {
        "standard": Kind(
            Variant(Table(_standard_of_G, forms=ENTRIES), "G"),
            Variant(Table(_standard, forms=ENTRIES)),
        ),
        "servo": Kind(
            Variant(Table(_servo_of_G, forms=ENTRIES), "G"),
            Variant(Table(_servo, forms=ENTRIES)),
        ),
        # Plants with names.
        "aircraft": aircraft_plant,
        "aircraft transition": aircraft_transition,
        "boost converter": by_name.sampled_boost_converter,
        "cart pendulum": by_name.sampled_cart_pendulum,
        "limited delay margin": by_name.sampled_delay_limited,
        "mass-spring-damper": by_name.sampled_mass_spring_damper,
        "no guaranteed margins": no_guaranteed_margins_standard,
        "rohrs": by_name.sampled_rohrs_plant,
    }
)


@dataclass(frozen=True)
class Change:
    """What the plant is from a step on; what is not named stays as it was.

    Parameters
    ----------
    start : int
        The step; a change at step 0 says what holds from the beginning, such as a delay.
    gain : number
        u acts this many times as strongly as B and the direct terms of [plant] say.
    delay : int
        u acts this many steps late; what was sent before the change is kept.
    ramp : bool
        The matrices move linearly and reach those of the next change at its start.
    state_map : matrix
        x <- state_map x at `start`; needed where the order changes.
    G : transfer function
        The new plant.
    A, B, C, D_0, D_1, D_2, E_0, E_1, E_2 : matrices
        The new ones. The state is kept, so that C and E_1 alone move the zeros.
    """

    start: int
    gain: Any = None
    delay: int | None = None
    ramp: bool = False
    state_map: Any = None
    G: Any = None
    A: Any = None
    B: Any = None
    C: Any = None
    D_0: Any = None
    D_1: Any = None
    D_2: Any = None
    E_0: Any = None
    E_1: Any = None
    E_2: Any = None


CHANGE = Table(
    Change,
    forms={
        **ENTRIES,
        "gain": Exact(),
        "delay": Integer(at_most=LONGEST_DELAY),
        "ramp": Flag(),
        "state_map": Numbers(),
    },
)


def _plant(
    problem: Plant | PlantSchedule, changes: Any = None, sample_time: Any = None
) -> Plant | PlantSchedule:
    """A plant.

    Parameters
    ----------
    problem : str
        Which problem the transfer function or the matrices are of, or a plant by its name.
    changes : tables
        How the plant changes while it runs.
    sample_time : number
        One step in seconds: reports give times too, and controllers go out with it.
    """
    if sample_time is None:
        return problem
    if isinstance(problem, PlantSchedule):
        changed = [replace(c, plant=_timed(c.plant, sample_time)) for c in problem.changes]
        return PlantSchedule(changed)
    return _timed(problem, sample_time)


def _timed(plant: Plant, sample_time: Any) -> Plant:
    """The plant with a sample time, of its exact data too."""
    if isinstance(sample_time, list):
        raise InputError(f"[plant] sample_time = {sample_time} must be one number, in seconds.")
    period = exact.exact_number(sample_time)
    if not (period.is_Rational and 0 < float(period) < float("inf")):
        raise InputError(f"[plant] sample_time = {sample_time!r} must be positive, in seconds.")
    known = None if plant.exact is None else replace(plant.exact, sample_time=period)
    return replace(plant, exact=known, sample_time=float(period))


PLANT = Deferred(
    Table(_plant, forms={"problem": PROBLEMS, "changes": ListOf(CHANGE), "sample_time": Exact()}),
    is_replaced=True,
)


@dataclass(frozen=True, eq=False)
class PlantSpecification:
    """A plant and what becomes of it, each change with the plant that it leads to."""

    first: Part[Plant | PlantSchedule]
    changes: tuple[tuple[Change, Part[Plant | PlantSchedule]], ...] | None

    def build(self) -> Plant | PlantSchedule:
        """The plant; with changes a schedule, each of them going on from the one before."""
        if self.changes is None:
            return self.first.build()
        made = [PlantChange(start=0, plant=_unchanging(self.first.build()))]
        gain, delay = 1, 0
        for index, (change, part) in enumerate(self.changes):
            gain = gain if change.gain is None else change.gain
            delay = delay if change.delay is None else change.delay
            if index == 0 and change.start == 0:
                made = []  # what the file says of step 0 itself
            made.append(
                PlantChange(
                    start=change.start,
                    plant=_amplified(_unchanging(part.build()), gain),
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
    first = PLANT.table.read(own, place)
    if "changes" not in table:
        return PlantSpecification(first, None)
    changes = []
    parts = ListOf(CHANGE).read(table["changes"], place.at("changes"))
    for number, (part, entry) in enumerate(zip(parts, table["changes"], strict=True), 1):
        given = {key: value for key, value in entry.items() if key in ENTRIES}
        if "G" in given or ("G" in own and given):
            own = {key: value for key, value in own.items() if key not in ENTRIES}
        own = {**own, **given}
        here = place.at("changes").entry(number).inside()
        changes.append((part.build(), PLANT.table.read(own, here)))
    return PlantSpecification(first, tuple(changes))


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
    return replace(made, sample_time=plant.sample_time)


def _require_coprime(G: Any) -> None:
    plant = exact.transfer_function(G)
    if plant.is_coprime is False:
        raise NotCoprimeError(
            "numerator and denominator of the plant G share the factor "
            f"{plant.common_factor().as_expr()}: no controller moves that pole. Cancel the factor, "
            "or give the matrices A, B, D_1 and C if the hidden mode is meant."
        )
