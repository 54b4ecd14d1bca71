"""The controller structures of an experiment file."""

from __future__ import annotations

import math
from typing import Any, Protocol

from compensator_theory.errors import InputError
from rcac_numeric.controllers.kinds import feedforward, fir, fir_integrator, iir, pid, quasi_fir
from rcac_numeric.controllers.structure import DerivedSignal, Structure, Tap
from rcac_numeric.experiments.format.lists import ListOf, Row
from rcac_numeric.experiments.format.parts import Later
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.format.values import Integer, Numbers, Real, Text


class Sizes(Protocol):
    """What a structure asks of a plant: how wide it is."""

    @property
    def l_u(self) -> int:
        """Number of control inputs."""

    @property
    def l_y(self) -> int:
        """Number of measurements."""

    @property
    def blocks(self) -> Any:
        """Widths of the blocks of w."""


def _derived(
    now: Any, before: Any = None, pole: float = 0.0, limit: float | None = None
) -> DerivedSignal:
    """A filter s(k) = pole s(k-1) + now e(k) + before e(k-1), e = [y; r], of the controller's own.

    Parameters
    ----------
    now, before : lists of numbers
        A weight for each component of e; `before` is zero where it is left out.
    pole : number
        In [-1, 1].
    limit : number
        s is held within +-limit.
    """
    past = tuple([0.0] * len(now) if before is None else before)
    return DerivedSignal(tuple(now), past, pole, math.inf if limit is None else limit)


def _taps(
    taps: list[tuple[str, int, int]],
    derived: list[DerivedSignal] | None = None,
    n_c: int = -1,
    *,
    l_u: int,
    l_y: int,
    sizes: Sizes,
) -> Structure:
    """A table of taps of your own.

    Parameters
    ----------
    taps : list of [signal, component, delay]
        The entries of the regressor; the signals are u, y, r and derived.
    derived : tables
        Filters of [y; r] that the controller runs itself.
    n_c : int
        Order; the longest delay where it is left out.
    """
    read, own = [Tap(*tap) for tap in taps], derived or []
    reads_r = any(tap.signal == "r" for tap in read) or any(len(s.now) > l_y for s in own)
    l_r = commands(sizes, "taps") if reads_r else 0
    return Structure(read, l_u, l_y, n_c, l_r=l_r, derived=own)


TAP = Row((Text(), Integer(), Integer()), '[signal, component, delay] such as ["y", 0, 1]')
DERIVED = Table(_derived, forms={"now": ListOf(Real()), "before": ListOf(Real()), "pole": Real()})
# What is said of the plant and does not stand in the file.
GIVEN = ("l_u", "l_y", "l_r", "sizes")

STRUCTURES: Kinds[Structure] = Kinds(
    {
        "iir": iir,
        "fir": fir,
        "quasi-fir": Table(
            quasi_fir, given=GIVEN[:2], docs={"free_poles": "How many lags of u there are."}
        ),
        "pid": pid,
        "fir + integrator": Table(fir_integrator, given=GIVEN[:2], forms={"F": Numbers()}),
        "feedforward": feedforward,
        "taps": Table(
            _taps,
            given=("l_u", "l_y", "sizes"),
            forms={"taps": ListOf(TAP), "derived": ListOf(DERIVED)},
        ),
    },
    default="iir",
    given=GIVEN,
)


def _structure(structure: Structure) -> Structure:
    """A controller structure by itself.

    Parameters
    ----------
    structure : str
        What the regressor is made of.
    """
    return structure


# [controller] as far as it says what the regressor is made of.
STRUCTURE = Table(_structure, forms={"structure": STRUCTURES})


def sizes_of(plant: Sizes) -> dict[str, Any]:
    """What a structure is given of the plant that it is to control."""
    return {
        "l_u": plant.l_u,
        "l_y": plant.l_y,
        "l_r": Later(lambda: commands(plant, "feedforward")),
        "sizes": plant,
    }


def commands(plant: Sizes, kind: str) -> int:
    """How many commands there are for a structure that reads them."""
    if not plant.blocks.get("r", 0):
        raise InputError(
            f'structure = "{kind}" reads the command r, but this plant\'s exogenous input has '
            f"{', '.join(plant.blocks) or 'no named block'}."
        )
    return int(plant.blocks["r"])
