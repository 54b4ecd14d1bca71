"""The controller structures of an experiment file: the functions of `controllers.kinds`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Annotated, Any

from compensator_theory.errors import InputError
from rcac_experiments.format._signatures import Composed
from rcac_experiments.format._tables import Kinds, Table
from rcac_experiments.format._values import Choice, Form, Integer, ListOf, Row, String
from rcac_numeric.controllers._kinds import feedforward, fir, fir_integrator, iir, pid, quasi_fir
from rcac_numeric.controllers._structure import DerivedSignal, Structure, Tap
from rcac_numeric.plants._any_plant import AnyPlant

DOCS = {"n_c": "Order, at least 1.", "free_poles": "How many lags of u there are."}
E_WEIGHTS = "A weight for each component of e; `before` is zero where it is left out."
TAP = Row((String(), Integer(), Integer()), '[signal, component, delay] such as ["y", 0, 1]')


def inputs(plant: AnyPlant) -> int:
    """Number of control inputs."""
    return plant.l_u


def outputs(plant: AnyPlant) -> int:
    """Number of measurements."""
    return plant.l_y


def commands(plant: AnyPlant, kind: str = "feedforward") -> int:
    """How many commands there are for a structure that reads them."""
    if not plant.blocks.get("r", 0):
        raise InputError(
            f'structure = "{kind}" reads the command r, but this plant\'s exogenous input has '
            f"{', '.join(plant.blocks) or 'no named block'}."
        )
    return int(plant.blocks["r"])


def _of_plant(make: Callable[..., Structure], **forms: Form) -> Table[Structure]:
    """The table of a function that makes a structure, whose widths are those of the plant."""
    whole = Composed(make, l_u=inputs, l_y=outputs, l_r=commands)
    return Table(whole, supplied=["plant", "kind"], forms=forms, docs=DOCS)


def derived_signal(
    now: Annotated[list[float], E_WEIGHTS],
    before: Annotated[list[float] | None, E_WEIGHTS] = None,
    pole: Annotated[float, "In [-1, 1]."] = 0.0,
    limit: Annotated[float | None, "s is held within +-limit."] = None,
) -> DerivedSignal:
    """A filter of the controller's own: s(k) = pole s(k-1) + now e(k) + before e(k-1)."""
    past = tuple([0.0] * len(now) if before is None else before)
    return DerivedSignal(tuple(now), past, pole, math.inf if limit is None else limit)


DERIVED = Table(derived_signal)


def custom_taps(
    plant: AnyPlant,
    taps: Annotated[
        list[tuple[str, int, int]],
        ListOf(TAP),
        "The entries of the regressor; the signals are u, y, r and derived.",
    ],
    derived: Annotated[
        Sequence[DerivedSignal],
        ListOf(DERIVED),
        "Filters of [y; r] that the controller runs itself.",
    ] = (),
    n_c: Annotated[int, "Order; the longest delay where it is left out."] = -1,
) -> Structure:
    """A table of taps of your own."""
    table_of_taps = [Tap(*tap) for tap in taps]
    reads_r = any(t.signal == "r" for t in table_of_taps) or any(
        len(s.now) > plant.l_y for s in derived
    )
    l_r = commands(plant, "taps") if reads_r else 0
    return Structure(table_of_taps, plant.l_u, plant.l_y, n_c, l_r=l_r, derived=derived)


STRUCTURES: Kinds[Structure] = Kinds(
    {
        "iir": _of_plant(iir),
        "fir": _of_plant(fir),
        "quasi-fir": _of_plant(quasi_fir),
        "pid": _of_plant(pid),
        "fir + integrator": _of_plant(fir_integrator),
        "feedforward": _of_plant(feedforward, feedback=Choice(("iir", "fir", "none"))),
        "taps": Table(custom_taps, supplied=["plant"]),
    },
    default="iir",
)


def _structure(structure: Annotated[Any, STRUCTURES]) -> Any:
    """[controller] as far as it says what the regressor is made of."""
    return structure


STRUCTURE = Table(_structure)
