"""Plants from transfer functions and exact problems, each entry rounded once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sympy import Symbol

import compensator_theory as exact
from compensator_theory.errors import Advice, ImproperError, InputError, NotCoprimeError
from compensator_theory.systems._conversions import transfer_function
from compensator_theory.systems._descriptions import has_states, shape_of
from compensator_theory.systems._foreign import is_foreign
from compensator_theory.systems._foreign import sample_time_of as exact_sample_time
from compensator_theory.systems._sample_times import shared_sample_time
from rcac_numeric.arrays._validation import rounded
from rcac_numeric.arrays._values import replaced
from rcac_numeric.plants._linear import MATRICES, Plant


def exact_realisation(system: Any, variable: str | None = None) -> exact.Realisation:
    """Return the exact realisation: that of a state space, else a minimal one.

    A scalar transfer function is realised with its common factors.
    """
    if has_states(system, variable):
        return exact.realisation(system, variable)
    matrix = exact.transfer_matrix(system, variable)
    if matrix.shape == (1, 1):
        return exact.realisation(matrix.scalar())
    return exact.minimal_realisation(matrix).realisation


def from_problem(problem: exact.StandardProblem, blocks: Mapping[str, int] | None = None) -> Plant:
    """Return the plant of an exact standard problem, each entry rounded once."""
    matrices: dict[str, Any] = {
        name: rounded(list(getattr(problem, name)), name).reshape(getattr(problem, name).shape)
        for name in MATRICES
    }
    period = None if problem.sample_time is None else float(problem.sample_time)
    return Plant(**matrices, blocks=dict(blocks or {}), exact=problem, sample_time=period)


def standard_plant(G: Any, variable: str | None = None) -> Plant:
    """The standard problem of a transfer function: y = z and w matched with u, (2.15).

    Parameters
    ----------
    G : anything `compensator_theory.transfer_function` accepts
        Strictly proper or exactly proper, in q or z.
    variable : {"q", "z"}, optional
        Of lists of coefficients and matrices, which do not show it.

    Examples
    --------
    >>> from rcac_numeric import standard_plant
    >>> standard_plant("(q - 1.2)/((q - 1.1)*(q - 2))")
    Plant(n=2, l_u=1, l_w=1, l_y=1, l_z=1)
    """
    return from_problem(_discrete(exact.standard_problem(G, variable), "{}"))


def servo_plant(G: Any = None, **matrices: Any) -> Plant:
    """The servo problem (2.16)-(2.27) of a transfer function (d and u colocated) or of matrices.

    Parameters
    ----------
    G : transfer function, optional
        Anything `compensator_theory.transfer_function` accepts; or one row of them,
        [[G_1, G_2]], for a plant whose inputs add up in one output, (6.7); or a system of
        python-control, SciPy or SymPy with any numbers of inputs and outputs, each input with a
        disturbance d of its own; or a Plant, whose map from u to y it is: `plant_of` samples what
        is in continuous time.
    **matrices
        A, B, D_1, C and D_0 of (2.16)-(2.17) in place of G; variable="q" or "z" of a G that does
        not show it; and
        performance="measured" (z = e_n, the default) or "true" (z = e_0).

    Returns
    -------
    Plant
        With w = [r; d; v] and y = e_n; a row of transfer functions has a d for each input.

    Raises
    ------
    NotCoprimeError
        Where all entries of a row and their common denominator share a factor: no controller
        moves that pole.

    Examples
    --------
    >>> from rcac_numeric import servo_plant
    >>> servo_plant("(q - 0.85)/((q - 0.8)*(q - 0.9))").blocks
    {'r': 1, 'd': 1, 'v': 1}
    >>> servo_plant([["1/(q - 0.8)", "(q - 2)/((q - 0.8)*(q - 0.9))"]])
    Plant(n=2, l_u=2, l_w=4, l_y=1, l_z=1)
    """
    if isinstance(G, list) and len(G) == 1 and isinstance(G[0], list) and len(G[0]) > 1:
        matrices, G = {**matrices, **realised_row(G[0])}, None
    if isinstance(G, Plant):
        p, G = G.problem, None
        plant_matrices = {"A": p.A, "B": p.B, "D_1": p.B, "C": p.C, "D_0": p.D_0}
        matrices = {
            **plant_matrices,
            "variable": p.variable,
            "sample_time": p.sample_time,
            **matrices,
        }
    variable = matrices.get("variable")
    if G is not None and shape_of(G, variable) != (1, 1):
        # Inputs and disturbances are matched, in the basis of the system or a minimal one.
        realisation = exact_realisation(G, variable)
        plant_matrices = {
            "A": realisation.A,
            "B": realisation.B,
            "D_1": realisation.B,
            "C": realisation.C,
            "D_0": realisation.D,
        }
        plant_matrices |= {"variable": realisation.variable, "sample_time": realisation.sample_time}
        matrices, G = {**plant_matrices, **matrices}, None
    problem = _discrete(exact.servo_problem(G, **matrices), "servo_plant({})")
    l_y = problem.C.shape[0]
    blocks = {"r": l_y, "d": problem.D_1.shape[1] - 2 * l_y, "v": l_y}
    return from_problem(problem, blocks)


def realised_row(entries: list[Any]) -> dict[str, Any]:
    """Return A, B, C of a row of strictly proper transfer functions, observer canonical form.

    Its order is the degree of the least common denominator D, so that it is controllable where the
    numerators over D and D itself have no factor in common.
    """
    entries_exact = [transfer_function(entry) for entry in entries]
    if len({str(g.variable) for g in entries_exact}) > 1:
        raise InputError("the entries of G are in different variables; write all of them in q.")
    if not all(g.is_strictly_proper for g in entries_exact):
        raise ImproperError(
            "an entry of G is not strictly proper, so that a disturbance at its input does not "
            "reach the output as u does; give the matrices A, B, D_1, C, D_0."
        )
    D = entries_exact[0].denominator
    for g in entries_exact[1:]:
        D = D.lcm(g.denominator)
    D = D.monic()
    numerators = [g.numerator * D.quo(g.denominator) for g in entries_exact]
    shared = D
    for N in numerators:
        shared = shared.gcd(N)
    if shared.degree() > 0:
        raise NotCoprimeError(
            f"all entries of G share the factor {shared.as_expr()} with their denominator: no "
            "controller moves that pole. Cancel the factor."
        )
    n = D.degree()
    below = [-D.nth(n - 1 - row) for row in range(n)]
    A = [[below[row], *(int(column == row) for column in range(n - 1))] for row in range(n)]
    return {
        "A": A,
        "B": [[N.nth(n - 1 - row) for N in numerators] for row in range(n)],
        "C": [[1] + [0] * (n - 1)],
        "variable": entries_exact[0].variable,
        "sample_time": shared_sample_time(*entries_exact),
    }


def sample_time_of(system: Any) -> float | None:
    """Return the sample time of a system; None for a text or without one."""
    if isinstance(system, exact.TransferFunction | exact.TransferMatrix | exact.Realisation):
        period = system.sample_time
    else:
        declared = getattr(system, "sample_time", None)
        period = exact_sample_time(system) if is_foreign(system) else declared
    return None if period is None else float(period)


def plant_of_problem(problem: exact.StandardProblem) -> Plant:
    """Return the plant of an exact standard problem in discrete time."""
    if str(problem.variable) not in ("q", "z"):
        raise InputError(
            f"the standard problem is in {problem.variable}, and plants here are in discrete time: "
            "sample it first, or ask compensator_theory, which has lqg_controller, lqg_poles and "
            "high_authority_limits of continuous time."
        )
    return from_problem(_discrete(problem, "{}"))


def _discrete(problem: exact.StandardProblem, call: str) -> exact.StandardProblem:
    """Return the problem in q; a continuous plant is refused with the call `call`."""
    if str(problem.variable) not in ("q", "z"):
        raise InputError(
            f"the plant is a transfer function in {problem.variable}; RCAC runs in discrete time. ",
            Advice(
                "plant_of",
                (("sample_time", "0.01"),),
                f"Sample it first: {call.format('{function}(system, sample_time={sample_time})')}, "
                "or write it in q",
            ),
            ".",
        )
    return problem if problem.variable == Symbol("q") else replaced(problem, variable="q")
