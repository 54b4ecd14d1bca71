"""`design` on logs of several signals, experiments, gaps and feedthrough, judged by the true plant.

Four kinds of logs, told apart in the table:

- "2x2": two inputs and outputs; entries of first and second order or nonminimum phase, all stable,
  some of them 0, each with its own dead time; moved by independent binary signals, white noise,
  steps one after another, signals that are correlated, an input at rest for half of the log, or a
  dither in a decentralised closed loop.
- "experiments": two or three records of one plant of one or two inputs and outputs, each with its
  own offsets and disturbance.
- "gaps": a tenth of the rows missing of a log of one or two inputs and outputs: single rows, runs
  of five on average, or one long gap.
- "feedthrough": y(k) responds to u(k), one input and output.

Disturbances are those of `benchmarks/identification.py`. A model that is handed out is *bad* where
an entry has the wrong sign at a third of the crossover (an angle above 90 degrees), or where the
loop of its fixed controller with the true plant is unstable. The oracle, asked of refused logs,
knows orders and delays, starts at the true coefficients and chooses the noise by BIC; *ok* is:
signs right, the loop of the controller for its model stable with the true plant.

The controllers are those of this file, the fastest LQG with a constant disturbance of u and Ms of
at most 1.6, since the weight grid of `design` takes ten times as long; `--design` takes `design`.

    .venv/bin/python benchmarks/identification_matrix.py [--kinds 2x2,gaps] [--seeds A:B] [--rows F]

`--quick` runs 3 logs of each kind.
"""

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from identification import (
    DISTURBANCES,
    TruePlant,
    disturbance_of,
    robust,
    sampled,
)
from scipy.linalg import solve_discrete_are
from scipy.signal import lfilter

from compensator_theory.errors import CompensatorError, NoSolutionError
from rcac_numeric import ControllerLog
from rcac_numeric.analysis._peaks import responses_of
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.designing._design import _basis_of_log, _DesignOptions
from rcac_numeric.designing._log_gates import GateLoop, controller_gates, design_plant
from rcac_numeric.designing._matrix_logs import (
    TRIED,
    MatrixLogSearch,
    matrix_plant,
    search_of_logs,
)
from rcac_numeric.designing._plants import DesignPlant, balanced
from rcac_numeric.designing._reference import loop_radius
from rcac_numeric.identification._box_jenkins import noise_start
from rcac_numeric.identification._joint_fits import (
    Channel,
    JointStart,
    joint_disturbance,
    joint_fit,
    reweighted,
)
from rcac_numeric.identification._joint_records import inputs_of, joint_record
from rcac_numeric.identification._joint_search import JointSearch
from rcac_numeric.identification._process_evidence import OMEGA as GATES
from rcac_numeric.identification._process_matrix import MatrixSearch

KINDS = ("2x2", "experiments", "gaps", "feedthrough")
MOVES = ("binary", "white", "steps", "correlated", "at rest", "dither")
CALMED = {"gain", "rivals", "draws", "parts", "halves"}  # gates that a slower loop may pass
OMEGA = np.geomspace(1e-3, np.pi, 200)
OPTIONS = _DesignOptions("unknown", None, None, None, None, None, False)
NOISES = ((1, 1, 0), (1, 0, 1), (2, 2, 0), (2, 1, 1))


def random_entry(rng, size, steps):
    """One entry with a gain of a size."""

    def between(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    k = size * rng.choice([-1, 1]) * between(0.5, 2)
    d = int(rng.choice([0, 0, 1, 2, 3, 5, 8]))
    family = rng.choice(["first", "second", "nonminimum"], p=[0.5, 0.35, 0.15])
    most = min(30, steps / 20)
    if family == "first":
        return sampled([k], [between(2, most), 1], d)
    if family == "second":
        return sampled([k], np.convolve([between(2, most), 1], [between(1, 8), 1]), d)
    T = between(3, most)
    top = k * np.array([-rng.uniform(0.2, 0.8) * T, 1])
    return sampled(top, np.convolve([T, 1], [between(2, 8), 1]), d)


def random_matrix(rng, m, steps):
    """Entries by rows; the smaller ones off the diagonal, some None."""
    rows = []
    for i in range(m):
        row = []
        for j in range(m):
            if i != j and rng.random() < 0.2:
                row.append(None)
            else:
                row.append(random_entry(rng, 1.0 if i == j else rng.uniform(0.1, 0.6), steps))
        rows.append(row)
    return rows


def matrix_of(entries):
    """The plant of entries."""
    m = len(entries)
    blocks = [(i, j, one) for i, row in enumerate(entries) for j, one in enumerate(row) if one]
    sizes = [max(len(one.A) - 1, len(one.B)) for *_, one in blocks]
    n, at = sum(sizes), 0
    A, B, C = np.zeros((n, n)), np.zeros((n, m)), np.zeros((m, n))
    late = np.zeros((n, m), dtype=np.int64)
    for (i, j, one), size in zip(blocks, sizes, strict=True):
        place = slice(at, at + size)
        a = np.eye(size, k=-1)
        a[0] = -np.pad(one.A[1:], (0, size - len(one.A) + 1))
        A[place, place], B[at, j] = a, 1.0
        C[i, place], late[place] = np.pad(one.B, (0, size - len(one.B))), one.delay
        at += size
    least = int(late.min())
    return DesignPlant(
        *balanced(A, B, C), least, later=late - least if (late > least).any() else None
    )


def response_of(entries, u):
    """The outputs of entries, at rest before."""
    y = np.zeros((len(u), len(entries)))
    for i, row in enumerate(entries):
        for j, one in enumerate(row):
            if one:
                y[:, i] += lfilter(np.r_[np.zeros(one.delay + 1), one.B], one.A, u[:, j])
    return y


def moves_of(kind, m, steps, slow, rng):
    """The inputs of a log, at rest in its first rows."""
    hold = max(1, int(slow * rng.uniform(0.2, 0.8)))
    u = np.stack([
        rng.choice([-1.0, 1.0], steps // h + 1).repeat(h)[:steps]
        for h in rng.integers(hold, 2 * hold + 1, m)
    ], 1)  # fmt: skip
    if kind == "white":
        u = rng.standard_normal((steps, m))
    elif kind == "steps":
        u = np.zeros((steps, m))
        for j in range(m):
            for part in range(2):  # up and down again, twice
                a, b = np.sort(rng.integers(10 + part * steps // 2, (part + 1) * steps // 2, 2))
                u[a : max(b, a + int(2 * slow)), j] += rng.choice([-1.0, 1.0])
    elif kind == "correlated" and m > 1:
        u[:, 1] = 0.8 * u[:, 0] + 0.6 * u[:, 1]
    elif kind == "at rest" and m > 1:
        u[: steps // 2, 1] = 0.0
    u[:5] = 0.0
    return u


@dataclass(frozen=True)
class SeveralLogs:
    """Logs of one plant, and what made them."""

    kind: str
    words: str
    entries: list
    logs: list
    is_direct: bool = False


def run_closed(entries, dither, d):
    """The loop of decentralised robust controllers; None where it is unstable."""
    loops = [robust(row[i], 1.8) for i, row in enumerate(entries)]
    if any(one is None for one in loops):
        return None
    plant = matrix_of(entries).servo()
    m, steps = len(entries), len(dither)
    A, B, C = plant.A, plant.B, -plant.C
    states = [np.zeros(len(loop[0][0])) for loop in loops]
    x, u, y = np.zeros(len(A)), np.zeros((steps, m)), np.zeros((steps, m))
    for k in range(steps):
        y[k] = C @ x + d[k]
        for i, (F, G, H, D) in enumerate(loop[0] for loop in loops):
            u[k, i] = H @ states[i] + D * y[k, i] + dither[k, i]
            states[i] = F @ states[i] + G * y[k, i]
        x = A @ x + B @ u[k]
        if np.abs(x).max() > 1e6:
            return None
    return u, y


def record_of(entries, rng, steps, moves, noise, kind):
    """One record of a plant."""
    slow = 10
    for row in entries:
        for one in row:
            if one:
                energy = np.cumsum(lfilter(one.B, one.A, np.eye(1, 2000)[0]) ** 2)
                slow = max(slow, int(np.searchsorted(energy, 0.9 * energy[-1])))
    m = len(entries)
    u = moves_of(moves, m, steps, slow, rng)
    y = response_of(entries, u)
    size = y.std(axis=0)
    d = np.stack([s * disturbance_of(kind, noise, steps, rng) for s in size], 1)
    if moves == "dither":
        closed = run_closed(entries, u, d)
        if closed is not None:
            u, y = closed
            return u + rng.uniform(-3, 3, m), y + size * rng.uniform(-3, 3, m)
    y = y + d
    if kind == "rounding":
        step = size * rng.choice([0.05, 0.2])
        y = np.round(y / step) * step
    return u + rng.uniform(-3, 3, m), y + size * rng.uniform(-3, 3, m)


def random_logs(kind, seed):
    """The logs of a seed."""
    rng = np.random.default_rng([50, KINDS.index(kind), seed])
    moves, noise = str(rng.choice(MOVES)), float(rng.choice([0.01, 0.03, 0.1, 0.3]))
    disturbance = str(rng.choice(DISTURBANCES))
    m = 2 if kind == "2x2" else 1 if kind == "feedthrough" else int(rng.choice([1, 2]))
    steps = int(rng.choice([300, 600, 1000]))
    words = f"{m} x {m}, {moves}, {disturbance}, {steps} rows, noise {noise:g}"
    entries = random_matrix(rng, m, steps)
    if kind == "feedthrough":
        one = entries[0][0]
        entries = [[TruePlant(one.B, one.A, 0)]]
        moves = str(rng.choice(MOVES[:3]))
        u, y = record_of(entries, rng, steps + 1, moves, noise, disturbance)
        words = f"{moves}, {disturbance}, {steps} rows, noise {noise:g}"
        return SeveralLogs(kind, words, entries, [ControllerLog(u[:-1], y[1:])], True)
    if kind == "experiments":
        count = int(rng.integers(2, 4))
        records = [
            record_of(entries, rng, max(steps // count, 150), moves, noise,
                      str(rng.choice(DISTURBANCES)))
            for _ in range(count)
        ]  # fmt: skip
        return SeveralLogs(kind, f"{count} of {words}", entries,
                           [ControllerLog(*one) for one in records])  # fmt: skip
    u, y = record_of(entries, rng, steps, moves, noise, disturbance)
    if kind == "gaps":
        form = str(rng.choice(["rows", "runs", "long"]))
        lost = rng.random(steps) < 0.1
        if form == "runs":
            lost = np.zeros(steps, dtype=bool)
            while lost.mean() < 0.1:
                at = int(rng.integers(5, steps))
                lost[at : at + int(rng.geometric(0.2))] = True
        if form == "long":
            at = int(rng.integers(steps // 4, steps // 2))
            lost = np.zeros(steps, dtype=bool)
            lost[at : at + steps // 10] = True
        u, y = u.copy(), y.copy()
        u[lost], y[lost] = np.nan, np.nan
        words = f"{form}, {words}"
    return SeveralLogs(kind, words, entries, [ControllerLog(u, y, has_gaps=kind == "gaps")])


def lqg(plant):
    """The fastest LQG of e with Ms at most 1.6, else that of the least Ms, and Ms; None if none."""
    return next(controllers(plant), None)


def controllers(plant):
    """LQG controllers of e and their Ms: the fastest with Ms at most 1.6, then slower ones.

    Where none has, that of the least Ms.
    """
    servo, m, best, is_robust = plant.servo(), plant.m, None, False
    A, B, C = servo.A, servo.B, -servo.C
    n, G = len(A), plant.response(OMEGA)
    size = np.linalg.norm(plant.response(0.02)[0], 2)
    joint = np.block([[A, B], [np.zeros((m, n)), np.eye(m)]])
    C_z, entry = np.hstack([C, np.zeros((m, m))]), np.vstack([B, np.zeros((m, m))])
    for weight in np.geomspace(1e-2, 1e5, 10):
        try:
            R, drift = weight * size**2 * np.eye(m), 0.1 / weight / size**2
            X = solve_discrete_are(A, B, C.T @ C + 1e-9 * (C**2).sum() * np.eye(n), R)
            K = np.linalg.solve(R + B.T @ X @ B, B.T @ X @ A)
            Q = np.zeros((n + m, n + m))
            Q[:n, :n] = 10 * drift * B @ B.T + 1e-10 * np.eye(n)
            Q[n:, n:] = drift * np.eye(m)
            P = solve_discrete_are(joint.T, C_z.T, Q, np.eye(m))
        except (np.linalg.LinAlgError, ValueError):
            continue
        L = joint @ P @ C_z.T @ np.linalg.inv(np.eye(m) + C_z @ P @ C_z.T)
        onto = -np.hstack([K, np.eye(m)])
        parts = (joint - L @ C_z + entry @ onto, -L, onto, np.zeros((m, m)))  # of e = -y
        if not loop_radius(servo, parts) < 1 - 1e-8:
            continue
        S = np.linalg.inv(np.eye(m) + G @ responses_of(parts, OMEGA))
        peak = float(np.linalg.norm(S, 2, axis=(1, 2)).max())
        if peak <= 1.6:
            is_robust = True
            yield parts, peak
        elif best is None or peak < best[1]:
            best = parts, peak
    if best is not None and not is_robust:
        yield best


def designed(logs):
    """The plant, the controller of e and the model that are handed out for logs."""
    data = logs.logs if len(logs.logs) > 1 else logs.logs[0]
    search, first = search_of_logs(data, None, 0.0), ()
    for count, fits in enumerate(search.candidates()):
        if count >= TRIED:
            break
        gates = search.first_gates(fits)
        if not all(gate.passed for gate in gates):
            first = first or gates
            continue
        logged = search.logged(fits, gates)
        for parts, peak in controllers(logged.plant):
            judged_gates = gates + gates_of(search, fits, logged, parts, peak)
            if all(gate.passed for gate in judged_gates):
                return logged.plant, parts, logged.model
            first = first or judged_gates
            failed = {gate.name.split()[0] for gate in judged_gates if not gate.passed}
            if not failed <= CALMED:
                break
    raise search.undecided(first) if first else NoSolutionError("no controller")


def gates_of(search, fits, logged, parts, peak):
    """The gates of a controller."""
    if isinstance(search, MatrixLogSearch):
        return search.controller_gates(fits, logged, parts, peak)
    L = logged.plant.response(GATES)[:, 0, 0] * responses_of(parts, GATES)[:, 0, 0]
    T, S = np.abs(L / (1 + L)), np.abs(1 / (1 + L))
    above = np.nonzero(np.abs(L) > 1)[0]
    crossover = float(GATES[above[-1]] if len(above) else 0.01)
    weight = np.where(crossover / 3 < GATES, T, np.minimum(T, S))
    loop = StateLoop(None, weight, crossover, states=parts)
    return controller_gates(search.search, fits, loop, peak, search.parts(fits), None)


@dataclass(frozen=True, eq=False)
class StateLoop(GateLoop):
    """The loop of a controller in state space."""

    states: tuple = ()

    @property
    def parts(self):
        """The controller's matrices."""
        return self.states


def judged(logs, plant, parts):
    """The entries of wrong sign, the spectral radius with the true plant, and where signs count."""
    true = matrix_of(logs.entries)
    radius = loop_radius(true.servo(), parts)
    L = plant.response(OMEGA) @ responses_of(parts, OMEGA)
    above = np.nonzero(np.linalg.svd(L, compute_uv=False)[:, 0] > 1)[0]
    low = OMEGA[above[-1]] / 3 if len(above) else 0.003
    G, H = true.response(low)[0], plant.response(low)[0]
    wrong = [
        (i, j) for i in range(true.m) for j in range(true.m)
        if G[i, j] and H[i, j] and not np.real(H[i, j] / G[i, j]) > 0
    ]  # fmt: skip
    return wrong, float(radius), low


def error_of(logs, plant, low):
    """The largest relative error about the crossover, which is 3 times `low`; in the 2-norm."""
    omega = np.geomspace(1.5 * low, min(6 * low, np.pi), 9)
    G, H = matrix_of(logs.entries).response(omega), plant.response(omega)
    norm = np.linalg.norm(G, 2, axis=(1, 2))
    return float(np.max(np.linalg.norm(H - G, 2, axis=(1, 2)) / norm))


def oracle_is_ok(logs, plant):
    """Whether a plant, that of the oracle, gives a good loop."""
    controller = lqg(plant) if plant is not None else None
    if controller is None:
        return False
    wrong, radius, _ = judged(logs, plant, controller[0])
    return not wrong and radius < 1


def oracle_plant(logs):
    """The true structure, fitted from the truth."""
    u = np.concatenate([log.u[1:] if logs.is_direct else log.u for log in logs.logs])
    y = np.concatenate([log.y[:-1] if logs.is_direct else log.y for log in logs.logs])
    sizes = [log.steps - logs.is_direct for log in logs.logs]
    inputs = inputs_of(u, tuple(int(k) for k in np.cumsum([0, *sizes[:-1]])))
    fits, searches = [], []
    for i, row in enumerate(logs.entries):
        record = joint_record(inputs, y[:, i], "y")
        channels = tuple(
            Channel(j, one.A, one.B * inputs.units[j] / record.unit_y, one.delay)
            for j, one in enumerate(row) if one
        )  # fmt: skip
        record = record.without_past(max(one.delay + len(one.B) for one in channels))
        v, best = joint_disturbance(record, channels), None
        for orders in NOISES:
            fit = joint_fit(record, JointStart(channels, noise_start(v, orders)))
            if fit is not None and fit.heavy:
                fit = reweighted(record, fit)
            if fit is not None and (best is None or fit.bic < best.bic):
                best = fit
        if best is None:
            return None
        fits.append(best)
        search = JointSearch.__new__(JointSearch)
        search.record = record
        searches.append(search)
    plant = matrix_plant(MatrixSearch(tuple(searches), inputs, (), False), fits, None)
    if plant.m == 1:
        one = fits[0].channels[0]
        unit = searches[0].record.unit_y / inputs.units[0]
        plant = design_plant(one.B, one.A, one.delay, unit, None)
    return plant


def row_of(kind, seed, by_design):
    """What became of the logs of a seed."""
    logs = random_logs(kind, seed)
    row = {"kind": kind, "seed": seed, "log": logs.words}
    start = time.process_time()
    try:
        if by_design:
            data = logs.logs if len(logs.logs) > 1 else logs.logs[0]
            basis = _basis_of_log(data, None, 0.0, OPTIONS)
            G_c, m = basis.reference.compensator, basis.model.m
            parts = Compensator(G_c.past_u, G_c.past_y[:, :, :m]).state_space()
            plant, model = basis.logged.plant, basis.logged.model
        else:
            plant, parts, model = designed(logs)
    except CompensatorError as error:
        row |= {"time": time.process_time() - start, "refused": str(error)}
        return row | {"oracle": oracle_is_ok(logs, oracle_plant(logs))}
    row["time"] = time.process_time() - start
    wrong, radius, low = judged(logs, plant, parts)
    oracle = oracle_plant(logs)
    return row | {
        "error": error_of(logs, plant, low),
        "oracle error": np.inf if oracle is None else error_of(logs, oracle, low),
        "wrong": wrong, "radius": radius, "bad": bool(wrong) or not radius < 1,
        "model": str(model),
    }  # fmt: skip


def quantiles(rows, name):
    """Median and 90 % quantile."""
    return ", ".join(
        f"{q:.2g}" for q in np.quantile([row[name] for row in rows] or [0], [0.5, 0.9])
    )


def print_table(rows):
    for kind in KINDS:
        of_kind = [row for row in rows if row["kind"] == kind]
        if not of_kind:
            continue
        out = [row for row in of_kind if "refused" not in row]
        lost = sum(row["oracle"] for row in of_kind if "refused" in row)
        ok = len(out) + lost
        print(
            f"{kind}: {len(of_kind)} logs, handed out {len(out)}, bad "
            f"{sum(row['bad'] for row in out)}; refused {len(of_kind) - len(out)}, though "
            f"oracle ok {lost} "
            f"({100 * lost / max(ok, 1):.0f} %); error about the crossover, median and 90 %: "
            f"{quantiles(out, 'error')} (oracle {quantiles(out, 'oracle error')}); CPU s a log, "
            f"median {np.median([row['time'] for row in of_kind]):.1f}"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--seeds", default="0:50", help="A:B, from A to B - 1, of each kind")
    parser.add_argument("--quick", action="store_true", help="seeds 0:3")
    parser.add_argument("--design", action="store_true", help="controllers of `design`")
    parser.add_argument("--rows", type=Path, help="write a line of JSON for each log")
    options = parser.parse_args()
    first, last = map(int, ("0:3" if options.quick else options.seeds).split(":"))
    rows = []
    for seed in range(first, last):
        for kind in options.kinds.split(","):
            row = row_of(kind, seed, options.design)
            rows.append(row)
            if options.rows:
                with options.rows.open("a") as file:
                    file.write(json.dumps(row, default=float) + "\n")
            if "refused" in row or row["bad"]:
                words = row.get("refused") or (
                    f"BAD wrong {row['wrong']}, radius {row['radius']:.4f}, {row['model']}"
                )
                oracle = " (oracle ok)" * bool(row.get("oracle"))
                print(f"{kind} {seed} {row['log']}{oracle}: {words[:300]}", flush=True)
    print_table(rows)


if __name__ == "__main__":
    main()
