"""Plant and controller of a run, checked and compiled once for many runs."""

from __future__ import annotations

from collections import OrderedDict
from functools import cached_property

import numpy as np

from compensator_theory.errors import Advice, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of
from rcac_numeric.arrays._values import fingerprint
from rcac_numeric.compiled import _kernel
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._controllers import (
    CONSTANT,
    Numbers,
    compiled_controller,
    instruction_set,
    numbers_beside,
)
from rcac_numeric.compiled._plants import compiled_plant, initial_state
from rcac_numeric.controllers._decentralized import Decentralized
from rcac_numeric.controllers._recursive import RecursiveLeastSquares
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.controllers._supervision import Supervision
from rcac_numeric.engine._compatibility import (
    AnyController,
    OneController,
    command_position,
    controllers_of,
    require_fit,
)
from rcac_numeric.engine._stepwise import StepwiseLoop
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._functions import FunctionPlant
from rcac_numeric.plants._saturation import Saturation

# Number of loops in the cache of a batch.
REMEMBERED = 64


class PreparedLoop:
    """The part of a run that depends on plant and controller only.

    A loop of data is compiled once, and each run has a copy of it at its first step; one that
    calls functions, steps in Python or learns its target model is compiled for each run.
    """

    def __init__(
        self,
        plant: AnyPlant,
        settings: AnyController,
        saturation: Saturation | None = None,
        supervision: Supervision | None = None,
    ) -> None:
        if saturation is not None:
            instance_of(saturation, "saturation", Saturation)
        if supervision is not None:
            instance_of(supervision, "supervision", Supervision)
        self.plant, self.settings, self.saturation = plant, settings, saturation
        is_default = supervision is None or supervision == Supervision()
        self.supervision = None if is_default else supervision
        # The key of the cache uses id(): the objects must stay alive.
        self._supervision_reference = supervision
        self.controllers = _compiled_controllers(settings, saturation, supervision)
        compiled_plant(plant, None, Failures())  # checks the plant
        require_fit(plant, settings)
        parts = self.controllers or (settings,)
        l_r = max(one.l_r for one in parts)
        self.command = command_position(plant, l_r), l_r
        self.adapts = any(one.l_theta for one in parts)
        adaptive = [one for one in self.controllers if isinstance(one, ControllerSettings)]
        self.learns = any(one.learning is not None for one in adaptive)
        self._numbers: Numbers | None = None
        # No function, no Python steps, no learnt target model.
        is_data = (
            bool(self.controllers)
            and not isinstance(plant, FunctionPlant)
            and not self.learns
            and all(isinstance(R, CONSTANT) for one in adaptive for R in (one.R_z, one.R_u))
        )
        self._template: _kernel.Loop | None = None
        # Size of the kernel's theta, coefficients of fixed controllers included; 0: not known yet.
        self.width = 0
        if is_data:
            compiled = self._compiled(None, 1.0, Failures())
            assert isinstance(compiled, _kernel.Loop)
            self._template, self.width = compiled, compiled.theta_before().size

    @property
    def is_data(self) -> bool:
        """Whether the loop is compiled once for all runs."""
        return self._template is not None

    def with_numbers_of(self, settings: AnyController) -> PreparedLoop | None:
        """Return the loop with settings that differ in numbers only; None if more differs."""
        base = self.settings
        if not isinstance(settings, ControllerSettings) or not isinstance(base, ControllerSettings):
            return None
        if self._template is None or (numbers := numbers_beside(base, settings)) is None:
            return None
        loop = object.__new__(PreparedLoop)
        loop.__dict__.update(self.__dict__)
        loop.__dict__.pop("name", None)
        loop.settings, loop.controllers, loop._numbers = settings, (settings,), numbers
        return loop

    def started(
        self, x_0: Array | None, limit: float, failures: Failures
    ) -> _kernel.Loop | StepwiseLoop:
        """Return the loop before its first step."""
        if self._template is None:
            return self._compiled(x_0, limit, failures)
        start = None if x_0 is None else initial_state(x_0, self.plant.n)
        return self._template.copy(limit, start, self._numbers)

    @cached_property
    def name(self) -> str:
        """The fingerprint of the loop, the identity of a state."""
        parts = (self.plant, self.settings, self.saturation)
        if not self.controllers:
            return fingerprint(parts[:2])
        return fingerprint(parts if self.supervision is None else (*parts, self.supervision))

    def _compiled(
        self, x_0: Array | None, limit: float, failures: Failures
    ) -> _kernel.Loop | StepwiseLoop:
        plant, settings, saturation = self.plant, self.settings, self.saturation
        body, r_in_w = compiled_plant(plant, x_0, failures), self.command[0]
        if isinstance(settings, StepwiseController):
            return StepwiseLoop(plant, settings, body, failures, limit, r_in_w)
        no_bounds = (np.zeros(0), np.zeros(0), np.zeros(0))
        low, high, rate = no_bounds if saturation is None else saturation.bounds(plant.l_u)
        shared = settings.shared_u if isinstance(settings, Decentralized) else True
        if saturation is not None and not shared and len(self.controllers) > 1:
            raise InputError(
                "with saturation, controllers with separate u do not receive their applied parts "
                "of u. ",
                Advice(
                    "Decentralized", (("shared_u", "True"),), "Use {function}(..., shared_u=True)"
                ),
                ".",
            )
        updates = [o.update for o in self.controllers if isinstance(o, ControllerSettings)]
        stops = [u.stop_where_unsupported for u in updates if isinstance(u, RecursiveLeastSquares)]
        return _kernel.Loop(
            controllers=[
                compiled_controller(one, plant.l_z, failures, supervision=self.supervision)
                for one in self.controllers
            ],
            plant=body,
            low=low,
            high=high,
            rate=rate,
            limit=limit,
            stop_where_unsupported=any(stops),
            shared_u=shared,
            r_in_w=r_in_w,
        )


class PreparedLoops:
    """Cache of the prepared loops of a batch."""

    def __init__(self) -> None:
        self._loops: OrderedDict[tuple[int, ...], PreparedLoop] = OrderedDict()
        self._bases: OrderedDict[tuple[int, ...], PreparedLoop] = OrderedDict()
        self._instructions = instruction_set()

    def begin(self) -> None:
        """Clear the cache if the instruction set has changed."""
        if self._instructions != (now := instruction_set()):
            self._loops.clear()
            self._bases.clear()
            self._instructions = now

    def of(
        self,
        plant: AnyPlant,
        settings: AnyController,
        saturation: Saturation | None = None,
        supervision: Supervision | None = None,
    ) -> PreparedLoop:
        """Return the prepared loop of these objects, which the cache keeps alive."""
        key = id(plant), id(settings), id(saturation), id(supervision)
        loop = self._loops.get(key)
        if loop is not None:
            return loop
        controllers_of(settings)  # refuses Python steps before the batch
        structure = getattr(settings, "structure", None)
        alike = id(plant), id(structure), id(saturation), id(supervision)
        base = self._bases.get(alike)
        prepared = None
        if base is not None:
            prepared = base.with_numbers_of(settings)
        if prepared is None:
            prepared = PreparedLoop(plant, settings, saturation, supervision)
            _keep(self._bases, alike, prepared)
        _keep(self._loops, key, prepared)
        return prepared


def _keep(
    store: OrderedDict[tuple[int, ...], PreparedLoop], key: tuple[int, ...], loop: PreparedLoop
) -> None:
    store[key] = loop
    if len(store) > REMEMBERED:
        store.popitem(last=False)


def _compiled_controllers(
    settings: AnyController, saturation: Saturation | None, supervision: Supervision | None
) -> tuple[OneController, ...]:
    """Return the controllers that the kernel runs; empty for Python steps."""
    if not isinstance(settings, StepwiseController):
        return controllers_of(settings)
    name = type(settings).__name__
    if saturation is not None:
        raise InputError(
            f"{name} does not support saturation: it would not receive the applied u. Leave "
            f"saturation out."
        )
    if supervision is not None:
        raise InputError(
            f"a {name} does not support supervision, which checks P of an RCAC controller; leave "
            f"supervision out."
        )
    return ()
