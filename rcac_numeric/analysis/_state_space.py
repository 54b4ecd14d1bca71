"""Readers of compensators in state space."""

from __future__ import annotations

from typing import Any

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import matrix
from rcac_numeric.arrays._wording import matrix_latex
from rcac_numeric.controllers._compensator import Compensator, compensator_of

StateSpace = tuple[Array, Array, Array, Array]


def state_space_of(compensator: Any, l_u: int, l_y: int) -> StateSpace:
    """Return (A_c, B_c, C_c, D_c) of a Compensator, a python-control system or four arrays."""
    if isinstance(compensator, str | exact.TransferFunction):
        compensator = compensator_of(compensator)
    if isinstance(compensator, Compensator):
        parts: Any = compensator.state_space()
    elif isinstance(compensator, tuple | list):
        parts = compensator
    else:
        parts = _of_control(compensator)
    if len(parts) != 4:
        raise InputError(
            f"a compensator in state space is (A_c, B_c, C_c, D_c); {len(parts)} matrices were "
            "given. Write D_c = 0 for a strictly proper one."
        )
    A_c = matrix(parts[0], "A_c", (None, None))
    n_c = len(A_c)
    return (
        matrix(A_c, "A_c", (n_c, n_c)),
        matrix(parts[1], "B_c", (n_c, l_y)),
        matrix(parts[2], "C_c", (l_u, n_c)),
        matrix(parts[3], "D_c", (l_u, l_y)),
    )


def _of_control(system: Any) -> StateSpace:
    is_control = type(system).__module__.split(".")[0] == "control"
    if not (is_control and type(system).__name__ in ("StateSpace", "TransferFunction")):
        raise InputError(
            f"{system!r} is no compensator; give a Compensator, a python-control system or "
            "(A_c, B_c, C_c, D_c)."
        )
    import control  # installed: the system comes from it

    if system.isctime(strict=True):
        raise InputError(
            "the compensator is in continuous time; discretise it first, with "
            "control.c2d(system, sample_time)."
        )
    system = control.ss(system)
    return system.A, system.B, system.C, system.D


def state_space_latex(state_space: StateSpace) -> str:
    r"""Return the four matrices of a compensator in LaTeX."""
    names = ("A_c", "B_c", "C_c", "D_c")
    parts = (f"{n} = {matrix_latex(m)}" for n, m in zip(names, state_space, strict=True))
    return r", \quad ".join(parts)
