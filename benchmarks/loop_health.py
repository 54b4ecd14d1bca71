"""Health against the truth: random loops, what is wrong with them, and what health says.

Run with: python benchmarks/loop_health.py [LOOPS] [FIRST_SEED]

Plants of order 1 to 4, standard and servo, with forgetting factors, k_w, R_theta, wrong signs,
saturations, jumps of the plant and faults of the sensor drawn at random. The truth is computed
here, without what health uses: eigenvalues of the frozen loop from its state space; the run goes on
with six other disturbances than health's, beside the same with theta held; the H2 cost by SciPy's
Lyapunov and Riccati solvers; poles that were asked for, from the roots of the loop.

A loop is bad where it did not end, is unstable, blew up to 1e4 times what acts on it, goes 100
times as far as with theta held, misses asked poles by more than 0.05, or costs more than twice
LQG's. Silent: bad, and not one warning. A false grave alarm: not bad, and a grave warning.
"""

from __future__ import annotations

import sys
import warnings
from collections import Counter
from dataclasses import dataclass

import numpy as np
from scipy import linalg, optimize

from compensator_theory.errors import CompensatorError
from rcac_numeric import (
    UD,
    CappedForgetting,
    Compensator,
    ControllerSettings,
    FixedController,
    PlantChange,
    PlantSchedule,
    Saturation,
    SubspaceForgetting,
    TargetModel,
    fir_target,
    iir,
    loop_health,
    pole_placement_target,
    simulate,
    standard_plant,
)
from rcac_numeric.plants._problems import servo_plant

FAR, COSTLY, MISSED, BLOWN = 100.0, 2.0, 0.05, 1e4


@dataclass
class Loop:
    """What was drawn."""

    plant: object
    settings: ControllerSettings
    w: np.ndarray
    saturation: Saturation | None
    noise: float
    words: str


def _polynomial(rng, degree: int, most: float) -> np.ndarray:
    roots: list[complex] = []
    while len(roots) < degree:
        if degree - len(roots) > 1 and rng.random() < 0.5:
            one = rng.uniform(0.1, most) * np.exp(1j * rng.uniform(0, np.pi))
            roots += [one, one.conjugate()]
        else:
            roots.append(rng.uniform(-most, most))
    return np.real(np.poly(roots[:degree])) if degree else np.ones(1)


def _words(p: np.ndarray) -> str:
    return " + ".join(f"({c:.6f})*q**{len(p) - 1 - i}" for i, c in enumerate(p))


def drawn(seed: int) -> Loop:
    """A loop of that seed."""
    rng = np.random.default_rng([2026, seed])
    n = int(rng.integers(1, 5))
    relative = int(rng.integers(1, min(3, n) + 1))
    poles, zeros = _polynomial(rng, n, 1.05), _polynomial(rng, n - relative, 0.85)
    gain = rng.choice([-1, 1]) * rng.uniform(0.3, 3)
    servo = bool(rng.random() < 0.4)
    make = servo_plant if servo else standard_plant
    G = f"({gain:.6f})*({_words(zeros)})/({_words(poles)})"
    plant = make(G)
    steps = int(rng.choice([500, 2000, 6000]))
    lambda_ = [1.0, 1.0, 1.0, 0.999, 0.99, CappedForgetting(0.99), SubspaceForgetting(0.99)][
        rng.integers(0, 7)
    ]
    places = bool(rng.random() < 0.4)
    if places:
        n_c = n + 1
        coefficients = [f"{v:.2f}" for v in rng.uniform(-0.3, 0.7, n_c + relative)]
        target = pole_placement_target(plant, coefficients)
    else:
        n_c, target = int(rng.integers(n, 2 * n + 3)), fir_target(plant)
    wrong = rng.random() < 0.08
    if wrong:
        target = TargetModel(-target.numerator, target.denominator)
    settings = ControllerSettings(
        structure=iir(n_c), target=target, k_w=[None, 50][rng.integers(0, 2)],
        update=UD(10.0 ** rng.uniform(-10, 2), lambda_=lambda_),
    )  # fmt: skip
    w, noise = np.zeros((steps, plant.l_w)), 0.0
    if servo:
        w[:, 0] = rng.choice([-1, 1])
        if rng.random() < 0.3:
            w[steps // 2 :, 0] *= 2
        if rng.random() < 0.25:  # a fault of the sensor
            w[rng.integers(60, steps, 3), -1] = rng.normal(0, 20, 3)
    else:
        noise = 1.0
        w[:] = rng.standard_normal(w.shape)
        if rng.random() < 0.5:  # quiet from some step on
            w[int(rng.uniform(0.1, 0.6) * steps) :] = 0.0
            noise = 0.0
    whole: object = plant
    if rng.random() < 0.15:
        other = make(f"({gain * rng.uniform(0.5, 2):.6f})*({_words(zeros)})/({_words(poles)})")
        whole = PlantSchedule(
            [PlantChange(start=0, plant=plant), PlantChange(start=steps // 2, plant=other)]
        )
    saturation = Saturation(low=-5, high=5) if rng.random() < 0.15 else None
    words = f"{'servo' if servo else 'standard'}, {G}, {lambda_}, {'poles' if places else 'FIR'}"
    return Loop(whole, settings, w, saturation, noise, words + (", wrong sign" if wrong else ""))


def truth(loop: Loop, run) -> list[str]:
    """What is wrong, computed without health."""
    if run.outcome != "completed":
        return ["ended: " + run.outcome]
    plant = loop.plant.changes[-1].plant if isinstance(loop.plant, PlantSchedule) else loop.plant
    c = run.compensator
    A_c, B_c, C_c, D_c = c.state_space()
    A = np.block([[plant.A + plant.B @ D_c @ plant.C, plant.B @ C_c], [B_c @ plant.C, A_c]])
    if np.abs(np.linalg.eigvals(A)).max() >= 1:
        return ["unstable"]
    outcomes = []
    idle = simulate(loop.plant, FixedController(_nothing(plant)), loop.w)
    scale = max(np.abs(run.w).max(), np.abs(idle.z).max() if idle.outcome == "completed" else 0.0)
    if np.abs(run.z).max() > BLOWN * scale:
        outcomes.append("blew up on the way")
    rng = np.random.default_rng(999)
    size = np.sqrt(np.mean((run.w - run.w.mean(axis=0)) ** 2, axis=0))
    size = np.where(size > 0, size, np.abs(run.w).max(axis=0))
    go_on = {"start": run.state, "saturation": loop.saturation}
    rest = np.broadcast_to(run.w[-1], (400, len(size)))
    plain = simulate(loop.plant, loop.settings, rest, **go_on)
    for share in (0.05, 0.3) * 3:
        kick = share * size * rng.choice([-1.0, 1.0], rest.shape)
        kicked = simulate(loop.plant, loop.settings, rest + kick, **go_on)
        steps = min(plain.steps, kicked.steps)
        added = np.abs(kicked.z[:steps] - plain.z[:steps]).max(initial=0.0)
        frozen = np.abs(simulate(plant, FixedController(c), kick).z).max()
        if kicked.outcome != "completed" or added > FAR * frozen:
            outcomes.append("next disturbance")
            break
    target = loop.settings.target
    if target.denominator[1:].any() and "wrong" not in loop.words:
        requested = np.roots(target.denominator[:, 0, 0])
        gaps = np.abs(requested[:, None] - np.linalg.eigvals(A)[None])
        rows, columns = optimize.linear_sum_assignment(gaps)
        if gaps[rows, columns].max() > MISSED:
            outcomes.append("missed poles")
    if loop.noise:
        B = np.vstack([plant.D_1 + plant.B @ D_c @ plant.D_2, B_c @ plant.D_2])
        E = np.hstack([plant.E_1 + plant.E_2 @ D_c @ plant.C, plant.E_2 @ C_c])
        W = plant.E_0 + plant.E_2 @ D_c @ plant.D_2
        J = np.trace(E @ linalg.solve_discrete_lyapunov(A, B @ B.T) @ E.T) + np.sum(W**2)
        try:
            least = _least(plant)
        except (np.linalg.LinAlgError, ValueError):
            least = None
        if least is not None and COSTLY * least * (1 + 1e-6) < J:
            outcomes.append("costly")
    return outcomes


def _nothing(plant) -> Compensator:
    return Compensator(np.zeros((0, plant.l_u, plant.l_u)), np.zeros((1, plant.l_u, plant.l_y)))


def _least(plant) -> float:
    """The cost of the predictor form, by SciPy, with weights of 1e-9 that make it regular."""
    eps = 1e-9
    R_2 = plant.E_2.T @ plant.E_2 + eps * np.eye(plant.l_u)
    V_2 = plant.D_2 @ plant.D_2.T + eps * np.eye(plant.l_y)
    P = linalg.solve_discrete_are(
        plant.A, plant.B, plant.E_1.T @ plant.E_1, R_2, s=plant.E_1.T @ plant.E_2
    )
    Q = linalg.solve_discrete_are(
        plant.A.T, plant.C.T, plant.D_1 @ plant.D_1.T, V_2, s=plant.D_1 @ plant.D_2.T
    )
    S = R_2 + plant.B.T @ P @ plant.B
    K = np.linalg.solve(S, plant.B.T @ P @ plant.A + plant.E_2.T @ plant.E_1)
    return float(
        np.trace(plant.D_1.T @ P @ plant.D_1) + np.trace(S @ K @ Q @ K.T) + np.sum(plant.E_0**2)
    )


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    warnings.simplefilter("ignore")
    table: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    for seed in range(first, first + count):
        try:
            loop = drawn(seed)
        except CompensatorError as error:  # a plant or a target that the package refuses
            table["not drawn"] += 1
            print(f"seed {seed}: {str(error)[:80]}", flush=True)
            continue
        with np.errstate(all="ignore"):
            run = simulate(loop.plant, loop.settings, loop.w, saturation=loop.saturation)
            wrong, health = truth(loop, run), loop_health(run)
        kinds.update(wrong)
        grave = [w.code for w in health.warnings if w.is_grave]
        if wrong:
            verdict = "bad, grave" if grave else "bad, warned" if health.warnings else "bad, SILENT"
        else:
            verdict = (
                "good, GRAVE" if grave else "good, warned" if health.warnings else "good, silent"
            )
        table[verdict] += 1
        if verdict in ("bad, SILENT", "good, GRAVE"):
            print(f"seed {seed}: {verdict}: {wrong or grave}; {loop.words}", flush=True)
    print(f"{count} loops: {dict(table)}; wrong: {dict(kinds)}")


if __name__ == "__main__":
    main()
