"""Plants made from transfer functions and exact problems, each entry rounded once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import rounded
from rcac_numeric.plants.linear import MATRICES, Plant


def from_problem(problem: exact.StandardProblem, blocks: Mapping[str, int] | None = None) -> Plant:
    """An exact standard problem, each entry rounded once to float64."""
    matrices = {
        name: rounded(list(getattr(problem, name)), name).reshape(getattr(problem, name).shape)
        for name in MATRICES
    }
    return Plant(**matrices, blocks=dict(blocks or {}), exact=problem)


def standard_plant(G: Any) -> Plant:
    """The standard problem of a transfer function: y = z and w matched with u, (2.15).

    Parameters
    ----------
    G : anything `compensator_theory.transfer_function` accepts
        Strictly proper or exactly proper, in q or z.

    Examples
    --------
    >>> from rcac_numeric import standard_plant
    >>> standard_plant("(q - 1.2)/((q - 1.1)*(q - 2))")
    Plant(n=2, l_u=1, l_w=1, l_y=1, l_z=1)
    """
    return from_problem(_discrete(exact.standard_problem(G)))


def servo_plant(G: Any = None, **matrices: Any) -> Plant:
    """The servo problem (2.16)-(2.27) of a transfer function (d and u colocated) or of matrices.

    Parameters
    ----------
    G : transfer function, optional
        Anything `compensator_theory.transfer_function` accepts.
    **matrices
        A, B, D_1, C and D_0 of (2.16)-(2.17) in place of G; and
        performance="measured" (z = e_n, the default) or "true" (z = e_0).

    Returns
    -------
    Plant
        With w = [r; d; v] and y = e_n.

    Examples
    --------
    >>> from rcac_numeric import servo_plant
    >>> servo_plant("(q - 0.85)/((q - 0.8)*(q - 0.9))").blocks
    {'r': 1, 'd': 1, 'v': 1}
    """
    problem = _discrete(exact.servo_problem(G, **matrices))
    l_y = problem.C.shape[0]
    return from_problem(problem, {"r": l_y, "d": problem.D_1.shape[1] - 2 * l_y, "v": l_y})


def _discrete(problem: exact.StandardProblem) -> exact.StandardProblem:
    if str(problem.variable) not in ("q", "z"):
        raise InputError(
            f"the plant is a transfer function in {problem.variable}; RCAC runs in discrete time. "
            "Discretise it first, for example with control.c2d, and write it in q."
        )
    return problem
