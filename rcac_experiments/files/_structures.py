"""The controller structures of an experiment file."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import attrs

from compensator_theory.errors import InputError
from rcac_experiments.format._parts import Shorthand, Unresolved
from rcac_experiments.format._tables import Kinds, Table
from rcac_experiments.format._values import Integer, ListOf, Row, Text
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.controllers._kinds import feedforward, fir, fir_integrator, iir, pid, quasi_fir
from rcac_numeric.controllers._structure import DerivedSignal, Structure, Tap
from rcac_numeric.plants._any_plant import AnyPlant

ORDER = "Order, at least 1."
FIRST_LAG = "First lag of y: 0 for an exactly proper controller, up to n_c."
LIMIT = "The integrator state is held within +-integral_limit."


class StructureKind(Unresolved):
    """A structure, but for the widths of the plant."""

    def of(self, plant: AnyPlant) -> Structure:
        """The structure for this plant."""
        raise NotImplementedError


@attrs.frozen
class Iir(StructureKind):
    """The IIR structure (2.28)-(2.33) of order `n_c`."""

    n_c: Annotated[int, ORDER]
    k_c: Annotated[int, FIRST_LAG] = 1

    def of(self, plant: AnyPlant) -> Structure:
        """With the plant's widths."""
        return iir(self.n_c, plant.l_u, plant.l_y, self.k_c)


@attrs.frozen
class Fir(StructureKind):
    """The FIR structure (2.34)-(2.35): every pole of the controller is at zero."""

    n_c: Annotated[int, ORDER]
    k_c: Annotated[int, FIRST_LAG] = 1

    def of(self, plant: AnyPlant) -> Structure:
        """With the plant's widths."""
        return fir(self.n_c, plant.l_u, plant.l_y, self.k_c)


@attrs.frozen
class QuasiFir(StructureKind):
    """The quasi-FIR structure (6.1): `free_poles` lags of u, the other poles at zero."""

    n_c: Annotated[int, ORDER]
    free_poles: Annotated[int, "How many lags of u there are."] = 2
    k_c: Annotated[int, FIRST_LAG] = 1

    def of(self, plant: AnyPlant) -> Structure:
        """With the plant's widths."""
        return quasi_fir(self.n_c, self.free_poles, plant.l_u, plant.l_y, self.k_c)


@attrs.frozen
class Pid(StructureKind):
    """The strictly proper PID structure (2.58)-(2.62), or some of its terms."""

    terms: Annotated[str, 'Any of "P", "I" and "D" in any order, each once.'] = "PID"
    k_c: Annotated[int, FIRST_LAG] = 1
    integral_limit: Annotated[float, LIMIT] = math.inf

    def of(self, plant: AnyPlant) -> Structure:
        """With the plant's widths."""
        limit = self.integral_limit
        return pid(self.terms, plant.l_u, plant.l_y, k_c=self.k_c, integral_limit=limit)


@attrs.frozen(eq=False)
class FirIntegrator(StructureKind):
    """An FIR controller with an integrator in parallel, (6.4)-(6.5)."""

    n_c: Annotated[int, ORDER]
    F: Annotated[
        Array | None,
        "Selects the components of y to integrate; all of them by default.",
    ] = None
    k_c: Annotated[int, FIRST_LAG] = 1
    integral_limit: Annotated[float, LIMIT] = math.inf

    def of(self, plant: AnyPlant) -> Structure:
        """With the plant's widths."""
        limit = self.integral_limit
        return fir_integrator(
            self.n_c, self.F, plant.l_u, plant.l_y, self.k_c, integral_limit=limit
        )


@attrs.frozen
class Feedforward(StructureKind):
    """Feedback and feedforward: the controller reads the measurement y and the command r."""

    n_c: Annotated[int, ORDER]
    k_c: Annotated[int, FIRST_LAG] = 1
    feedback: Annotated[
        Literal["iir", "fir", "none"],
        '"iir" reads past u, y and r; "fir" past y and r; "none" past u and r.',
    ] = "iir"
    first_r: Annotated[int | None, "First lag of r; `k_c` by default, 0 is allowed."] = None

    def of(self, plant: AnyPlant) -> Structure:
        """With the plant's widths, and its commands."""
        return feedforward(
            self.n_c, plant.l_u, plant.l_y, commands(plant, "feedforward"),
            k_c=self.k_c, feedback=self.feedback, first_r=self.first_r,
        )  # fmt: skip


E_WEIGHTS = "A weight for each component of e; `before` is zero where it is left out."


@attrs.frozen
class Derived(Shorthand):
    """A filter of the controller's own: s(k) = pole s(k-1) + now e(k) + before e(k-1)."""

    now: Annotated[list[float], E_WEIGHTS]
    before: Annotated[list[float] | None, E_WEIGHTS] = None
    pole: Annotated[float, "In [-1, 1]."] = 0.0
    limit: Annotated[float | None, "s is held within +-limit."] = None

    def made(self) -> DerivedSignal:
        """The filter itself."""
        past = tuple([0.0] * len(self.now) if self.before is None else self.before)
        limit = math.inf if self.limit is None else self.limit
        return DerivedSignal(tuple(self.now), past, self.pole, limit)


TAP = Row((Text(), Integer(), Integer()), '[signal, component, delay] such as ["y", 0, 1]')


@attrs.frozen(eq=False)
class Taps(StructureKind):
    """A table of taps of your own."""

    taps: Annotated[
        list[tuple[str, int, int]],
        ListOf(TAP),
        "The entries of the regressor; the signals are u, y, r and derived.",
    ]
    derived: Annotated[
        list[DerivedSignal],
        ListOf(Table(Derived)),
        "Filters of [y; r] that the controller runs itself.",
    ] = attrs.field(factory=list)
    n_c: Annotated[int, "Order; the longest delay where it is left out."] = -1

    def of(self, plant: AnyPlant) -> Structure:
        """With the plant's widths, and its commands where one of them is read."""
        taps, own = [Tap(*tap) for tap in self.taps], self.derived
        reads_r = any(t.signal == "r" for t in taps) or any(len(s.now) > plant.l_y for s in own)
        l_r = commands(plant, "taps") if reads_r else 0
        return Structure(taps, plant.l_u, plant.l_y, self.n_c, l_r=l_r, derived=own)


STRUCTURES: Kinds[StructureKind] = Kinds(
    {
        "iir": Iir,
        "fir": Fir,
        "quasi-fir": QuasiFir,
        "pid": Pid,
        "fir + integrator": FirIntegrator,
        "feedforward": Feedforward,
        "taps": Taps,
    },
    default="iir",
)


@attrs.frozen
class StructureAlone:
    """[controller] as far as it says what the regressor is made of."""

    structure: Annotated[StructureKind, STRUCTURES]


STRUCTURE = Table(StructureAlone)


def commands(plant: AnyPlant, kind: str) -> int:
    """How many commands there are for a structure that reads them."""
    if not plant.blocks.get("r", 0):
        raise InputError(
            f'structure = "{kind}" reads the command r, but this plant\'s exogenous input has '
            f"{', '.join(plant.blocks) or 'no named block'}."
        )
    return int(plant.blocks["r"])
