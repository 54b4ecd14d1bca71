"""What a controller is handed at a step, read and refused by name; and a step that failed."""

from __future__ import annotations

from typing import Any, NoReturn

from numpy.typing import ArrayLike

from compensator_theory.errors import (
    CompensatorError,
    DivergedError,
    FunctionFailedError,
    InputError,
)
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import vector
from rcac_numeric.controllers.settings import ControllerSettings

StepArguments = tuple[Array, Array, Array | None, Array | None]


def step_arguments(
    settings: ControllerSettings, y: Any, z: Any, r: Any, u_applied: Any
) -> StepArguments:
    """The arguments of a step as arrays.

    Parameters
    ----------
    settings : ControllerSettings
        That say how wide they are.
    y, z : arrays or numbers
    r, u_applied : arrays, numbers, or None

    Raises
    ------
    InputError
        Where one is not what it should be.
    """
    structure = settings.structure
    if (r is None) != (structure.l_r == 0):
        raise InputError(f"the structure reads l_r = {structure.l_r} commands; r = {r!r}.")
    return (
        vector(y, "y", structure.l_y),
        vector(z, "z", settings.target.l_z),
        None if r is None else vector(r, "r", structure.l_r),
        None if u_applied is None else vector(u_applied, "u_applied", structure.l_u),
    )


def refuse_u_applied(settings: ControllerSettings, k: int, u_applied: ArrayLike) -> NoReturn:
    """Say why what was applied cannot be taken in at step k.

    Parameters
    ----------
    settings : ControllerSettings
    k : int
    u_applied : array or number

    Raises
    ------
    InputError
        Always.
    """
    vector(u_applied, "u_applied", settings.structure.l_u)
    if k == 0:
        raise InputError("u_applied belongs to the step before; at step 0 there is none.")
    raise InputError("u_applied needs a strictly proper target model.")


def failed_step(k: int, cause: BaseException | None) -> tuple[str, CompensatorError]:
    """What a controller whose step k failed says from then on, and the error of that step.

    Parameters
    ----------
    k : int
    cause : exception, optional
        Of a weight that is a function.
    """
    if cause is not None:
        words = f"a weight that is a function failed at step {k}: {cause}"
        return "a weight of this controller has failed; start a new one.", FunctionFailedError(
            words
        )
    words = (
        f"the controller left the range of float64 at step {k}; its coefficients are no longer "
        "usable. Start a new one, with a larger R_theta or another target."
    )
    return words, DivergedError(words)


def busy() -> InputError:
    """What a step says to who comes in the middle of it."""
    return InputError(
        "the controller is in the middle of a step: neither a weight that is a function "
        "nor another thread may drive it meanwhile. Use one controller for each loop."
    )
