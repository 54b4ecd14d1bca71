"""Which instructions of the processor the kernel uses."""

from __future__ import annotations

import os

from compensator_theory.errors import InputError
from rcac_numeric.engine import _kernel

VARIABLE = "RCAC_INSTRUCTION_SET"


def require_instruction_set() -> None:
    """Raise where the environment asks for instructions that this processor does not have.

    The environment variable RCAC_INSTRUCTION_SET forces one of `_kernel.instruction_sets()` on
    everything that is made from then on; without it the kernel takes the first. They round in
    different orders: theta differs by about 1e-15 from one to the next.
    """
    name, known = os.environ.get(VARIABLE, ""), _kernel.instruction_sets()
    if name and name not in known:
        raise InputError(
            f"{VARIABLE} = {name!r} is no instruction set of this processor; it runs "
            f"{', '.join(known)}."
        )


def instruction_set() -> str:
    """The instructions that everything is made with from now on; raises where there are none."""
    require_instruction_set()
    return os.environ.get(VARIABLE, "") or _kernel.instruction_sets()[0]
