"""Several adaptive controllers on one plant, each with its update (figure 2.16)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of, items, real_array
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._compensator import Compensator, parallel
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._structure import DerivedSignal, Structure, Tap
from rcac_numeric.targets._model import TargetModel


@dataclass(frozen=True, eq=False)
class Decentralized(Value):
    """Controllers whose outputs are added: u = u_1 + u_2 + ....

    Parameters
    ----------
    controllers : sequence of ControllerSettings
        All with the same l_u, l_y, l_r and l_z; theta is stacked in their order.
    shared_u : bool
        False, the default: each controller's regressor and target-model filter hold its own
        output, so that each has poles of its own. True: they hold the sum.

    Examples
    --------
    >>> from rcac_numeric import UD, ControllerSettings, Decentralized, TargetModel, feedforward
    >>> common = {"target": TargetModel([0, 1]), "update": UD(R_theta=1e5)}
    >>> both = Decentralized([
    ...     ControllerSettings(structure=feedforward(10, feedback="fir"), **common),
    ...     ControllerSettings(structure=feedforward(10, feedback="none"), **common)])
    >>> both.l_theta
    40
    """

    controllers: Sequence[ControllerSettings]
    shared_u: bool = False

    def __post_init__(self) -> None:
        controllers = items(self.controllers, "controllers", ControllerSettings)
        object.__setattr__(self, "controllers", controllers)
        instance_of(self.shared_u, "shared_u", bool)
        if not controllers:
            raise InputError("a decentralised controller needs a list of ControllerSettings.")
        widths = {(c.structure.l_u, c.structure.l_y, c.target.l_z) for c in controllers}
        if len(widths) > 1:
            raise InputError(f"the controllers differ in (l_u, l_y, l_z): {sorted(widths)}.")
        if any(c.fixed is not None for c in controllers):
            raise InputError(
                "one of several controllers has a fixed compensator in parallel; only a single "
                "controller can have one."
            )
        commands = {c.structure.l_r for c in controllers} - {0}
        if len(commands) > 1:
            raise InputError(f"the controllers differ in l_r: {sorted(commands)}.")

    @property
    def target(self) -> TargetModel:
        """The target model of the first controller."""
        return self.controllers[0].target

    @property
    def l_theta(self) -> int:
        """Number of all controller coefficients."""
        return sum(c.structure.l_theta for c in self.controllers)

    @property
    def l_r(self) -> int:
        """Number of commands that the controllers read."""
        return max(c.structure.l_r for c in self.controllers)

    def compensator_of(self, theta: ArrayLike) -> Compensator:
        """Return the fixed compensator from [y; r] to the sum u."""
        values = real_array(theta, "theta").reshape(-1)
        if values.size != self.l_theta:
            raise InputError(f"theta has {values.size} entries; {self.l_theta} are needed.")
        ends = np.cumsum([c.structure.l_theta for c in self.controllers])[:-1]
        coefficients = np.split(values, ends)
        if self.shared_u:
            return _sum_of_one_u([c.structure for c in self.controllers], coefficients)
        parts = [
            _with_commands(c.structure.compensator(part), self.l_r - c.structure.l_r)
            for c, part in zip(self.controllers, coefficients, strict=True)
        ]
        total = parts[0]
        for part in parts[1:]:
            total = parallel(total, part)
        return total


def _with_commands(compensator: Compensator, missing: int) -> Compensator:
    padding = [(0, 0), (0, 0), (0, missing)]
    return Compensator(compensator.past_u, np.pad(compensator.past_y, padding))


def _sum_of_one_u(structures: list[Structure], coefficients: list[Array]) -> Compensator:
    """Return u = sum Phi_i theta_i as one structure: every Phi_i reads the same u.

    The poles of derived signals then act on these signals only. Adding the difference equations
    of the parts would apply the poles to the sum u.
    """
    first, l_r = structures[0], max(s.l_r for s in structures)
    columns: dict[Tap, Array] = {}
    derived: list[DerivedSignal] = []
    for structure, theta in zip(structures, coefficients, strict=True):
        for tap, column in zip(structure.taps, theta.reshape(-1, first.l_u), strict=True):
            shift = len(derived) if tap.signal == "derived" else 0
            shifted = replace(tap, component=tap.component + shift)
            columns[shifted] = columns.get(shifted, 0.0) + column
        nothing = (0.0,) * (l_r - structure.l_r)
        derived += [
            replace(signal, now=signal.now + nothing, before=signal.before + nothing)
            for signal in structure.derived
        ]
    n_c = max(structure.n_c for structure in structures)
    whole = Structure(tuple(columns), first.l_u, first.l_y, n_c, "sum", l_r, derived)
    return whole.compensator(np.concatenate(list(columns.values())))
