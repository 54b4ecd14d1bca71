"""Checks that plant and controller fit."""

from __future__ import annotations

from compensator_theory.errors import ImproperError, InputError
from rcac_numeric.arrays._validation import instance_of
from rcac_numeric.controllers._decentralized import Decentralized
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.plants._any_plant import AnyPlant, block_start
from rcac_numeric.plants._foreign import agreed_times

# A single controller, and the controllers of `simulate`.
OneController = ControllerSettings | FixedController
AnyController = OneController | Decentralized | StepwiseController


def controllers_of(controller: AnyController) -> tuple[OneController, ...]:
    """Return every controller in the loop."""
    instance_of(controller, "settings", AnyController)
    if isinstance(controller, StepwiseController):
        raise InputError(
            f"a {type(controller).__name__} computes its steps in Python: `simulate` runs it, "
            "batches and the reference arithmetic do not. Call `simulate` for each case."
        )
    if isinstance(controller, Decentralized):
        return tuple(controller.controllers)
    return (controller,)


def command_position(plant: AnyPlant, l_r: int) -> int:
    """Return the first channel of the command in w; raise without one of the right width."""
    if l_r == 0:
        return 0
    width = plant.blocks.get("r", 0)
    if width != l_r:
        raise InputError(
            f"the controller reads a command with l_r = {l_r}; the plant's exogenous input has "
            f"the blocks {dict(plant.blocks)}. Use servo_plant, or name a block 'r' of that width."
        )
    return block_start(plant, "r")


def require_fit(plant: AnyPlant, controller: AnyController) -> None:
    """Raise if plant and controller do not fit."""
    if isinstance(controller, StepwiseController):
        _require_stepwise_fits(plant, controller)
        return
    for one in controllers_of(controller):
        if isinstance(one, ControllerSettings):
            _require_settings_fit(plant, one)
        else:
            _require_fixed_fits(plant, one)
        command_position(plant, one.l_r)


def _require_settings_fit(plant: AnyPlant, controller: ControllerSettings) -> None:
    structure = controller.structure
    _require_sizes(plant, l_u=structure.l_u, l_y=structure.l_y, l_z=controller.target.l_z)
    if controller.measures_first and plant.y_needs_u:
        raise _algebraic_loop()
    if controller.form == "filter" and (plant.y_needs_u or plant.z_needs_u):
        raise ImproperError(
            'form = "filter" needs y(k) and z(k) before u(k), but D_0 or E_2 is not zero. Use '
            'form = "predictor".'
        )


def _require_fixed_fits(plant: AnyPlant, controller: FixedController) -> None:
    c = controller.compensator
    agreed_times([plant, c])
    _require_sizes(plant, l_u=c.l_u, l_y=c.l_y - controller.l_r)
    if c.past_y[0].any() and plant.y_needs_u:
        raise _algebraic_loop()


def _require_stepwise_fits(plant: AnyPlant, controller: StepwiseController) -> None:
    _require_sizes(plant, l_u=controller.l_u, l_y=controller.l_y)
    if plant.y_needs_u:
        raise ImproperError(
            f"a {type(controller).__name__} computes u(k) from y(k), but D_0 is not zero, so that "
            "they depend on each other. Delay the control in the plant by a step."
        )
    command_position(plant, controller.l_r)


def _require_sizes(plant: AnyPlant, **sizes: int) -> None:
    for name, of_controller in sizes.items():
        if (of_plant := getattr(plant, name)) != of_controller:
            raise InputError(
                f"the plant has {name} = {of_plant} and the controller {name} = {of_controller}."
            )


def _algebraic_loop() -> ImproperError:
    return ImproperError(
        "the controller is exactly proper (k_c = 0) and D_0 is not zero, so u(k) and y(k) "
        "depend on each other. Use k_c = 1."
    )
