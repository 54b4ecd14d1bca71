"""Reference controllers of another structure: PID, FIR, and feedforward of the command."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from compensator_theory.errors import InputError, NoSolutionError
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.designing._expected import Expected
from rcac_numeric.designing._plants import DesignPlant
from rcac_numeric.designing._reference import MOST, Reference, WeightGrid

OMEGA = np.geomspace(1e-4, np.pi, 400)  # rad/sample, at which controllers are compared
SHARES = (1.0, 0.5, 0.2, 0.05)  # of a fitted controller: a weaker one may be stable where it is not
SOME = 40  # fitted controllers that are run where the actuator has limits
FEW = 6  # coefficients that are improved by search
TRIES = 80  # evaluations for each of them
UNSTABLE = 1e6  # cost of a loop that is not
RIDGE = 1e-6  # of the largest column: what a direction must contribute to be fitted
MOVES = 1e-2  # least weight of the steps of u, over the square of the gain, against the error


def require_reducible(structure: Structure) -> None:
    """Raise an error for a structure with free poles, or that reads a command."""
    if not isinstance(structure, Structure):
        raise InputError(f"structure = {structure!r}: give one such as pid('PI') or fir(20).")
    if (structure.l_u, structure.l_y) != (1, 1):
        raise InputError(
            f"structure: {structure.name} has {structure.l_u} controls and {structure.l_y} "
            "measurements, but design needs one of each; leave structure out."
        )
    if structure.l_r or any(tap.signal == "u" for tap in structure.taps):
        raise InputError(
            f"structure: {structure.name} reads {'r' if structure.l_r else 'its own past u'}; give "
            "one of y alone, such as pid('PI'), fir(20) or fir_integrator(20). Without "
            "structure the controller is an IIR one of the order that the plant needs, and "
            "feedforward=True lets it read the command."
        )


def reduced_reference(grid: WeightGrid, structure: Structure) -> Reference:
    """Fit a structure to the LQG loops of a weight grid, and improve it by a search.

    Of each LQG controller C of the weight grid the coefficients are fitted that minimise

        sum over omega of abs(S^2 G (Phi theta - C))^2 (abs(G)^2 Phi_d + Phi_v),

    which is what the difference makes of the error to first order. The loop that is robust (as
    `reference_loop` says) at least cost is taken, else the most robust; up to six coefficients are
    improved by Nelder and Mead's search.
    """
    require_reducible(structure)
    taps = _responses(structure)
    G = grid.response(OMEGA)
    spectrum = np.abs(G) ** 2 * grid.disturbance_spectrum(OMEGA) + grid.noise_variance
    candidates = []
    for R_2, V_2, parts in grid.candidates():
        A, B, C, _ = parts
        z = np.exp(1j * OMEGA)[:, None, None]
        response = (C @ np.linalg.solve(z * np.eye(len(A)) - A, B[None] + 0j))[:, 0, 0]
        S = 1 / (1 - G * response)
        theta = _fitted(taps, response, np.abs(S**2 * G) * np.sqrt(spectrum * OMEGA))
        candidates += [
            (grid.judged(_parts(structure, share * theta)), R_2, V_2, share * theta)
            for share in SHARES
        ]
    candidates.sort(key=lambda one: one[0].order)
    if not candidates or not np.isfinite(candidates[0][0].peak):
        raise NoSolutionError(
            f"no {structure.name} controller with {structure.l_theta} coefficients that was tried "
            "stabilises the plant; leave structure out, or give one with more coefficients."
        )
    thetas = [candidates[0][-1]]
    if len(thetas[0]) <= FEW:
        thetas.insert(0, _improved(grid, structure, thetas[0]))
    if grid.saturation is not None:  # which the cost knows nothing of
        thetas += [theta for *_, theta in candidates[1:SOME]]
        safe = [grid.judged(_parts(structure, one)).safe for one in thetas]
        thetas = [one for one, how in zip(thetas, safe, strict=True) if how == min(safe)]
        compensators = [grid.in_units(structure.compensator(one)) for one in thetas]
        thetas = [thetas[grid.in_runs(compensators)[0]]]
    theta, by = thetas[0], grid.units[0] / grid.units[1]
    full = grid.best()
    return replace(
        full, compensator=grid.in_units(structure.compensator(theta)),
        peak=grid.judged(_parts(structure, theta)).peak, structure=structure, theta=theta * by,
        full=full.compensator,
    )  # fmt: skip


def _responses(structure: Structure) -> ComplexArray:
    """The response of u to y per coefficient; shape (frequencies, l_theta)."""
    past = np.exp(-1j * OMEGA)
    columns = []
    for tap in structure.taps:
        column = past**tap.delay
        if tap.signal == "derived":
            signal = structure.derived[tap.component]
            column = column * (signal.now[0] + signal.before[0] * past) / (1 - signal.pole * past)
        columns.append(column)
    return np.array(columns).T


def _fitted(columns: ComplexArray, response: ComplexArray, weight: Array) -> Array:
    """Solve a complex least-squares problem for real coefficients."""
    rows = np.concatenate([part * weight[:, None] for part in (columns.real, columns.imag)])
    right = np.concatenate([part * weight for part in (response.real, response.imag)])
    size = np.linalg.norm(rows, axis=0)
    size[size == 0] = 1.0
    return np.asarray(np.linalg.lstsq(rows / size, right, rcond=RIDGE)[0] / size)


def _parts(structure: Structure, theta: Array) -> tuple[Array, Array, Array, Array]:
    return structure.compensator(theta).state_space()


def _improved(grid: WeightGrid, structure: Structure, theta: Array) -> Array:
    """Improve the coefficients by a search in relative units; the result is never worse."""
    size = np.where(theta == 0, np.abs(theta).max() or 1.0, theta)

    def cost(x: Array) -> float:
        judgement = grid.judged(_parts(structure, x * size))
        if not np.isfinite(judgement.peak):
            return UNSTABLE * (1 + judgement.lost)
        narrow = max(1.0, judgement.peak / MOST) ** 6 * (1 + judgement.lost) ** 4
        return float(np.sqrt(judgement.error) * narrow * max(1.0, judgement.wide))

    start = theta / size
    optimum = minimize(
        cost, start, method="Nelder-Mead",
        options={"maxfev": TRIES * len(theta), "xatol": 1e-3, "fatol": 1e-4},
    )  # fmt: skip
    return np.asarray(optimum.x * size) if optimum.fun < cost(start) else theta


def with_feedforward(plant: DesignPlant, reference: Reference, expected: Expected) -> Reference:
    """Add feedforward of the command r to the reference, under the same denominator.

    u = D_c^-1 (N_e e + N_r r); the loop, and what it does to d and v, stays as it is. N_r minimises
    the error that a step of r leaves, abs(S (1 - G N_r/D_c) R)^2, and the steps of u that it takes.
    """
    if plant.m > 1:
        raise InputError("feedforward is for one input and one output; leave it out.")
    if expected.command is None:
        raise InputError("feedforward reads the command: give command=Step(...), or leave it out.")
    if reference.structure is not None:
        raise InputError("feedforward and structure exclude each other; give one of them.")
    G_c = reference.compensator
    past, n_c = np.exp(-1j * OMEGA), G_c.n_c
    powers = past[:, None] ** np.arange(1, n_c + 1)
    D_c = 1 - powers @ G_c.past_u[:, 0, 0]
    C, G = powers @ G_c.past_y[1:, 0, 0] / D_c, plant.response(OMEGA)[:, 0, 0]
    S = 1 / (1 + G * C)  # e = r - G u
    # R = 1/(1 - q^-1); times the square root of omega, for a grid that is even in its logarithm
    R, into = np.sqrt(OMEGA) / np.abs(1 - past), powers / D_c[:, None] * S[:, None]
    weight = np.sqrt(max(reference.R_2, MOVES)) * plant.low_gain
    moves = weight * np.sqrt(OMEGA)
    columns = np.concatenate([G[:, None] * into * R[:, None], into * moves[:, None]])
    right = np.concatenate([S * R, -S * C * moves])
    N_r = _fitted(columns, right, np.ones(len(right)))
    past_y = np.concatenate([G_c.past_y, np.r_[0.0, N_r][:, None, None]], axis=2)
    return replace(reference, compensator=Compensator(G_c.past_u, past_y, G_c.sample_time))
