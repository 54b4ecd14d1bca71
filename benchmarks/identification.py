"""`design(log)` on synthetic process logs, judged by the true plant, beside an oracle.

Seven families of plants (first and second order, oscillating, integrating, unstable, nonminimum
phase, 4 to 8 equal lags), gains of either sign, dead times of 0 to 60 steps; eleven disturbances of
the output (white, coloured, random walks, level jumps, drift, sinusoid, spikes, rounding); six
excitations (binary, white, an early and a late step, setpoint steps and a dither in closed loop);
200 to 5000 rows with offsets of u and y.

A model that is handed out is *bad* where its sign is wrong (the angle between its response and that
of the plant is above 90 degrees at a third of the crossover) or the loop of its fixed controller
with the true plant is unstable. The oracle knows orders, delay and kind of the plant, starts at its
coefficients and chooses noise models by BIC; *ok* is: sign right, the loop of this file's LQG with
the true plant stable, relative error about the crossover below 0.5.

    .venv/bin/python benchmarks/identification.py [--seeds A:B] [--rows FILE] [--all] [--beside]

300 seeds by default. `--rows` writes one line of JSON a seed and does not repeat seeds of the file;
`--all` prints every log, not only the bad ones and those that are refused where the oracle is ok.
`--beside` runs other estimators, whose model is judged with this file's LQG: output error and the
closed loop's (`identify_output_error`, `identify_in_closed_loop`), refined instrumental variables
with ARIMA(1, 1, 1) noise (P. C. Young), and SIPPY's N4SID, PARSIM-K and ARMAX where `sippy-unipi`
and `tf2ss` are installed, on the first 20 seeds. None of them has gates; what they cannot do counts
as refused.
"""

import argparse
import contextlib
import importlib.util
import io
import json
import time
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.linalg import matrix_balance, solve_discrete_are
from scipy.signal import cont2discrete, lfilter, ss2tf
from scipy.stats import beta

from compensator_theory.errors import CompensatorError
from rcac_numeric import ControllerLog
from rcac_numeric.compiled._box_jenkins import confined
from rcac_numeric.designing._design import _basis_of_log, _DesignOptions
from rcac_numeric.identification import (
    identify_in_closed_loop,
    identify_output_error,
    identify_process,
)
from rcac_numeric.identification._box_jenkins import (
    Start,
    disturbance,
    fitted,
    later,
    noise_start,
    weighted_fit,
)
from rcac_numeric.identification._delay_scan import regression_start, scanned_again
from rcac_numeric.identification._process_records import process_record
from rcac_numeric.identification._process_search import delay_costs

FAMILIES = ("first", "second", "oscillating", "integrating", "unstable", "nonminimum", "lags")
DISTURBANCES = (
    "white", "coloured", "walk 0.01", "walk 0.03", "walk 0.1", "1 jump", "2 jumps", "drift", "sine",
    "spikes", "rounding",
)  # fmt: skip
EXCITATIONS = ("binary", "white", "early step", "late step", "setpoint", "dither")
DELAYS = (0, 0, 1, 2, 3, 5, 8, 10, 15, 20, 30, 45, 60)
LENGTHS, SHARES = (200, 500, 1000, 1500, 3000, 5000), (0.15, 0.2, 0.2, 0.25, 0.1, 0.1)
SLOW_LOGS = 20  # of the first seeds those that SIPPY runs
OMEGA = np.geomspace(1e-4, np.pi, 400)
NOISES = ((0, 0, 0), (1, 1, 0), (1, 0, 1), (2, 2, 0), (2, 1, 1))  # of the oracle


@dataclass(frozen=True)
class TruePlant:
    """q^-delay (b_1 q^-1 + ...)/A."""

    B: np.ndarray
    A: np.ndarray
    delay: int

    def response(self, omega):
        """G(exp(j omega))."""
        past = np.exp(-1j * np.atleast_1d(omega))
        top = np.polyval(self.B[::-1], past) * past ** (self.delay + 1)
        return top / np.polyval(self.A[::-1], past)

    def lag(self):
        """The states without the delay."""
        n = max(len(self.A) - 1, len(self.B))
        A = np.eye(n, k=1)
        A[:, 0] = -np.pad(self.A[1:], (0, n - len(self.A) + 1))
        B, C = np.pad(self.B, (0, n - len(self.B))), np.eye(1, n)[0]
        A, (scale, _) = matrix_balance(A, permute=False, separate=True)
        return A, B / scale, C * scale

    def states(self):
        """The states, the last of them u one step ago."""
        A, B, C = self.lag()
        n, d = len(A), self.delay
        if not d:
            return A, B, C
        whole, into = np.eye(n + d, k=1), np.eye(1, n + d, n + d - 1)[0]
        whole[:n] = 0
        whole[:n, :n], whole[:n, n] = A, B
        return whole, into, np.pad(C, (0, d))


def sampled(numerator, denominator, delay):
    """A plant in continuous time with one step as unit of time."""
    b, A, _ = cont2discrete((numerator, denominator), 1.0)
    b = np.where(np.abs(b.ravel()) < 1e-14 * np.abs(b).max(), 0.0, b.ravel())
    first = np.nonzero(b)[0][0]
    return TruePlant(b[first:], A, delay + first - 1)


@dataclass(frozen=True)
class HeldPlant:
    """A plant whose controller acts once in so many rows, u held in between."""

    plant: TruePlant
    every: int

    def states(self):
        """The states of the plant, once in so many rows."""
        A, B, C = self.plant.states()
        B_n = sum((np.linalg.matrix_power(A, i) @ B for i in range(self.every)), np.zeros(len(A)))
        return np.linalg.matrix_power(A, self.every), B_n, C

    def response(self, omega):
        """G(exp(j omega))."""
        A, B, C = self.states()
        points = np.exp(1j * np.atleast_1d(omega))[:, None, None] * np.eye(len(A)) - A
        return (
            np.linalg.solve(points, np.broadcast_to(B[:, None], (*points.shape[:2], 1)))[..., 0] @ C
        )


def lqg(plant, rho, drift):
    """LQG with a constant disturbance of u, the state predicted over the delay; (A, B, C, D)."""
    A, B, C = plant.lag()
    n, d = len(A), plant.delay
    size = 1e-9 * (C @ C) * np.eye(n)
    X = solve_discrete_are(A, B[:, None], np.outer(C, C) + size, [[rho]])
    K = (B @ X @ A) / (rho + B @ X @ B)
    joint = np.eye(n + 1)
    joint[:n, :n], joint[:n, n] = A, B
    C_z, Q = np.append(C, 0.0), np.zeros((n + 1, n + 1))
    Q[:n, :n] = 10 * drift * np.outer(B, B) + 1e-10 * (B @ B) * np.eye(n)
    Q[n, n] = drift
    P = solve_discrete_are(joint.T, C_z[:, None], Q, [[1.0]])
    gain = P @ C_z / (1 + C_z @ P @ C_z)
    update = np.eye(n + 1) - np.outer(gain, C_z)
    powers = [np.linalg.matrix_power(A, i) @ B for i in range(d)]
    onto = -np.append(K @ np.linalg.matrix_power(A, d), K @ sum(powers, np.zeros(n)) + 1.0)
    whole = np.zeros((n + 1 + d, n + 1 + d))
    into = np.zeros(n + 1 + d)
    out = np.concatenate([onto @ update, [-(K @ one) for one in powers]])
    whole[: n + 1, : n + 1], into[: n + 1] = joint @ update, joint @ gain
    direct, control = onto @ gain, np.append(B, 0.0)
    if d:
        whole[: n + 1, -1] += control
        whole[n + 1], into[n + 1] = out, direct
        for i in range(1, d):
            whole[n + 1 + i, n + i] = 1.0
    else:
        whole[: n + 1] += np.outer(control, out)
        into[: n + 1] += control * direct
    return whole, into, out, direct


def radius(plant, controller):
    """The spectral radius of the loop of a plant with a controller from y to u."""
    A, B, C = plant.states()
    F, G, H, D = controller
    loop = np.block([[A + D * np.outer(B, C), np.outer(B, H)], [np.outer(G, C), F]])
    return float(np.abs(np.linalg.eigvals(loop)).max())


def robust(plant, most=1.6, slower=1.0):
    """The fastest stable LQG with Ms at most `most`, else that of the least; Ms and crossover."""
    best, G = None, plant.response(OMEGA)
    size = np.median(np.abs(plant.response(np.geomspace(1e-3, np.pi, 60)))) + 1e-12
    for weight in np.geomspace(1e-3, 1e5, 13) * slower:
        try:
            controller = lqg(plant, weight * size**2, 0.1 / weight / size**2 / (1 + plant.delay))
        except (np.linalg.LinAlgError, ValueError):
            continue
        F, into, out, direct = controller
        modes, vectors = np.linalg.eig(F)
        if not np.linalg.cond(vectors) < 1e10:
            points = np.exp(1j * OMEGA)[:, None, None] * np.eye(len(F)) - F
            right = np.broadcast_to(into[:, None], (len(OMEGA), len(F), 1))
            K = np.linalg.solve(points, right)[..., 0] @ out + direct
        else:
            shares = (out @ vectors) * np.linalg.solve(vectors, into)
            K = (shares / (np.exp(1j * OMEGA)[:, None] - modes)).sum(axis=1) + direct
        peak = np.abs(1 / (1 - G * K)).max()
        if not np.isfinite(peak) or not (peak <= most or best is None or peak < best[1]):
            continue
        if radius(plant, controller) < 1 - 1e-8:
            above = np.nonzero(np.abs(G * K) > 1)[0]
            best = controller, float(peak), float(OMEGA[above[-1]] if len(above) else 0.01)
            if peak <= most:
                break
    return best


def random_plant(family, rng):
    """One plant of a family."""

    def between(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    k, d = rng.choice([-1, 1]) * between(0.3, 3), int(rng.choice(DELAYS))
    if family == "first":
        return sampled([k], [between(2, 40), 1], d)
    if family == "second":
        return sampled([k], np.convolve([between(2, 30), 1], [between(1, 15), 1]), d)
    if family == "oscillating":
        w, damping = between(0.05, 0.6), rng.uniform(0.05, 0.5)
        return sampled([k * w**2], [1, 2 * damping * w, w**2], d)
    if family == "integrating":
        T = between(1, 10)
        return sampled([k / T / 3], [T, 1, 0], min(d, 30))
    if family == "unstable":
        p = between(0.02, 0.15)
        return sampled([k * p], np.convolve([1, -p], [between(0.5, 5), 1]), min(d, int(0.3 / p)))
    if family == "nonminimum":
        T = between(3, 20)
        top = k * np.array([-rng.uniform(0.3, 1.5) * T, 1])
        return sampled(top, np.convolve([T, 1], [between(2, 10), 1]), min(d, 20))
    T, A = between(1, 6), np.ones(1)
    for _ in range(int(rng.integers(4, 9))):
        A = np.convolve(A, [T, 1])
    return sampled([k], A, min(d, 10))


@dataclass(frozen=True)
class ProcessLog:
    """A log, what made it, and the crossover of a robust loop with its plant."""

    plant: TruePlant
    family: str
    disturbance: str
    excitation: str
    noise: float
    u: np.ndarray
    y: np.ndarray
    r: np.ndarray | None
    crossover: float

    def __str__(self):
        return (
            f"{self.family}, dead time {self.plant.delay}, {self.disturbance}, {self.excitation}, "
            f"{len(self.u)} rows, noise {self.noise:g}"
        )


def random_log(seed):
    """The log of a seed."""
    rng = np.random.default_rng([49, seed])
    while True:
        family, kind = rng.choice(FAMILIES), rng.choice(DISTURBANCES)
        excitation = rng.choice(EXCITATIONS[4:] if family == "unstable" else EXCITATIONS)
        plant, steps = random_plant(family, rng), int(rng.choice(LENGTHS, p=SHARES))
        if steps < 6 * plant.delay + 100:
            continue
        loop, reference = robust(plant, 2.0, rng.choice([1, 10])), robust(plant)
        if loop is not None and reference is not None and reference[1] <= 4:
            break
    is_closed = excitation in EXCITATIONS[4:]
    moves = excitation_of(excitation, plant, family, steps, rng)
    _, y = run(plant, loop[0], excitation, moves, np.zeros(steps))
    size = np.std(y) * (0.3 if family == "integrating" and not is_closed else 1.0)
    noise = float(rng.choice([0.1, 0.3, 1.0, 2.0] if excitation == "dither" else
                             [0.01, 0.03, 0.1, 0.3]))  # fmt: skip
    u, y = run(plant, loop[0], excitation, moves, size * disturbance_of(kind, noise, steps, rng))
    if kind == "rounding":
        step = size * rng.choice([0.05, 0.2, 0.5])
        y = np.round(y / step) * step
    offsets = rng.uniform(-3, 3, 2)
    r = moves if excitation == "setpoint" else None
    return ProcessLog(
        plant, str(family), str(kind), str(excitation), noise, u + offsets[0],
        y + size * offsets[1], r, reference[2],
    )  # fmt: skip


def excitation_of(kind, plant, family, steps, rng):
    """What moves u, or the command."""
    slow = 10 if family == "unstable" else 15
    if family not in ("unstable", "integrating"):
        energy = np.cumsum(lfilter(plant.B, plant.A, np.eye(1, 4000)[0]) ** 2)
        slow = max(2, int(np.searchsorted(energy, 0.9 * energy[-1])))
    k = np.arange(steps)
    if kind in ("binary", "dither"):
        hold = 1 if rng.random() < 0.3 else max(1, int(slow * rng.uniform(0.1, 0.6)))
        return rng.choice([-1.0, 1.0], steps // hold + 1).repeat(hold)[:steps]
    if kind == "white":
        return rng.standard_normal(steps)
    if kind == "early step":
        return 1.0 * (k >= rng.integers(3, 16))
    if kind == "late step":
        second = 0.7 * (k >= int(0.75 * steps)) if rng.random() < 0.4 else 0.0
        return 1.0 * (k >= rng.integers(steps // 5, steps // 2)) - second
    hold = min(max(10, int(rng.uniform(2, 6) * (slow + plant.delay))), steps // 6)
    return rng.uniform(-1, 1, steps // hold + 1).repeat(hold)[:steps]


def disturbance_of(kind, noise, steps, rng):
    """Noise and disturbance of the output, in units of what u makes of it."""
    e, k = rng.standard_normal(steps), np.arange(steps)
    if kind == "coloured":
        a = rng.uniform(0.5, 0.97)
        return 2 * noise * np.sqrt(1 - a**2) * lfilter([1.0], [1, -a], e)
    d = noise * e
    if kind.startswith("walk"):
        d = d + float(kind[5:]) * np.cumsum(rng.standard_normal(steps))
    if "jump" in kind:
        for _ in range(int(kind[0])):
            size = rng.choice([-1, 1]) * rng.choice([1, 3, 6])
            d = d + size * (k >= rng.uniform(0.15, 0.85) * steps)
    if kind == "drift":
        d = d + rng.choice([-1, 1]) * rng.choice([1, 3, 10]) * k / steps
    if kind == "sine":
        d = d + rng.choice([0.5, 2, 6]) * np.sin(rng.uniform(0.01, 0.06) * k + rng.uniform(0, 6))
    if kind == "spikes":
        at = rng.integers(0, steps, max(1, steps // 200))
        d[at] += rng.choice([-1, 1]) * rng.choice([3, 10, 100])
    return d


def run(plant, controller, excitation, moves, d):
    """Run the plant: u and y of a record."""
    if excitation not in EXCITATIONS[4:]:
        shifted = np.concatenate([np.zeros(plant.delay + 1), plant.B])
        return moves, lfilter(shifted, plant.A, moves) + d
    A, B, C = plant.states()
    F, G, H, D = controller
    x, state, steps = np.zeros(len(A)), np.zeros(len(F)), len(moves)
    u, y = np.zeros(steps), np.zeros(steps)
    command, dither = (moves, 0 * moves) if excitation == "setpoint" else (0 * moves, moves)
    for k in range(steps):
        y[k] = C @ x + d[k]
        e = y[k] - command[k]
        u[k] = H @ state + D * e + dither[k]
        state, x = F @ state + G * e, A @ x + B * u[k]
    return u, y


def agreement(log, response):
    """Whether the sign is right, and the relative error about the crossover."""
    low = np.array([log.crossover / 3])
    near = np.geomspace(log.crossover / 2, min(2 * log.crossover, np.pi), 9)
    sign = np.real(response(low) / log.plant.response(low)).item() > 0
    true = log.plant.response(near)
    return bool(sign), float(np.max(np.abs(response(near) - true) / np.abs(true)))


def oracle_is_ok(log):
    """Whether the true structure, fitted from the truth, gives a good loop; and its error."""
    if np.ptp(log.u) == 0:
        return False, np.inf
    record, plant = process_record(log.u, log.y), log.plant
    unit_u, unit_y = record.units
    best, n = None, len(plant.A) - 1
    is_unstable = log.family == "unstable"
    for n_C, n_D, i in NOISES:
        orders = (n, n_D, i) if is_unstable else (n_C, n_D, i)
        B, white = plant.B * unit_u / unit_y, noise_start(record.y, (0, 0, i))
        start = Start(plant.A, B, plant.delay, white, armax=is_unstable)
        noise = noise_start(disturbance(record, start), orders)
        fit = fitted(record, replace(start, noise=noise))
        if fit is not None and fit.heavy:
            fit = weighted_fit(record, fit)
        if fit is not None and (best is None or fit.bic < best.bic):
            best = fit
    if best is None:
        return False, np.inf
    model = TruePlant(best.B * unit_y / unit_u, best.A, plant.delay)
    sign, error = agreement(log, model.response)
    loop = robust(model)
    return loop is not None and sign and error < 0.5 and radius(plant, loop[0]) < 1, error


def row_of(seed):
    """What became of one log."""
    log = random_log(seed)
    row = {
        "seed": seed, "log": str(log), "family": log.family, "disturbance": log.disturbance,
        "excitation": log.excitation,
    }  # fmt: skip
    row["oracle"], row["oracle error"] = oracle_is_ok(log)
    options = _DesignOptions("unknown", None, None, None, None, None, False)
    data = ControllerLog(log.u, log.y) if log.r is None else ControllerLog(log.u, log.y, r=log.r)
    start = time.process_time()
    try:
        basis = _basis_of_log(data, None, 0.0, options)
    except CompensatorError as error:
        refusal = {"refused": str(error), "kind": type(error).__name__}
        return row | {"time": time.process_time() - start} | refusal
    row["time"] = time.process_time() - start
    plant, G_c, every = basis.logged.plant, basis.reference.compensator, basis.logged.every
    truth = log
    if every > 1:  # of a dead time of more than 60 rows
        truth = replace(
            log, plant=HeldPlant(log.plant, every), crossover=min(every * log.crossover, np.pi / 2)
        )
    sign, error = agreement(truth, lambda omega: plant.response(omega)[:, 0, 0])
    A, B, C, D = G_c.state_space()
    # The compensator is one from e = -y to u.
    loop = radius(truth.plant, (A, -B[:, 0], C[0], -D.item()))
    model = basis.logged.model
    return row | {
        "sign": sign, "error": error, "radius": loop, "bad": not (sign and loop < 1),
        "delay": every * plant.delay - log.plant.delay, "model": str(model),
        "gates": {gate.name: gate.value for gate in model.gates},
    }  # fmt: skip


def identification_time(seed):
    """CPU seconds of `identify_process` on the log of a seed."""
    log, start = random_log(seed), time.process_time()
    with contextlib.suppress(CompensatorError):
        identify_process(log.u, log.y)
    return time.process_time() - start


def output_error(log):
    model = identify_output_error(log.u, log.y, integrators=(0, 1))
    return TruePlant(model.numerator, model.denominator, model.delay)


def closed_loop(log):
    model = identify_in_closed_loop(log.u, log.y, integrators=(0, 1))
    return TruePlant(model.numerator, model.denominator, model.delay)


def refined_iv(log):
    """Refined instrumental variables, of the orders 1 to 3 that of the least BIC."""
    record, best = process_record(log.u, log.y), None
    steps, costs = record.steps, delay_costs(record)
    y, u = np.diff(record.y, prepend=0.0), np.diff(record.u, prepend=0.0)
    for n in (1, 2, 3):
        past, B, delay, _ = regression_start(y, u, (), n, costs)
        A = confined(np.append(1.0, past), 0.999)
        for count in range(12):
            delayed = later(record.u, delay)
            x = lfilter(np.append(0.0, B), A, delayed)
            noise = noise_start(record.y - x, (1, 1, 1))
            filtered = lfilter(noise.whitener, np.convolve(noise.C, A), [record.y, delayed, x])
            y_f, u_f, x_f = (np.stack([later(one, k) for k in range(1, n + 1)]) for one in filtered)
            Z, P = np.concatenate([-x_f, u_f]), np.concatenate([-y_f, u_f])
            theta = np.linalg.lstsq(Z @ P.T, Z @ filtered[0], rcond=None)[0]
            A, B = confined(np.append(1.0, theta[:n]), 0.9999), theta[n:]
            if count == 5:
                scan = scanned_again(
                    record, A, noise.C, noise.whitener, slope=False, summed=False, count=n,
                    delays=len(costs),
                )  # fmt: skip
                delay = int((steps * np.log(scan.squares[0]) + costs).argmin())
                B = scan.numerators[0, delay]
        x = lfilter(np.append(0.0, B), A, later(record.u, delay))
        e = lfilter(noise.whitener, noise.C, record.y - x)[3:]
        bic = steps * np.log(np.mean(e**2)) + 2 * n * np.log(steps)
        if np.isfinite(bic) and (best is None or bic < best[0]):
            best = bic, B * record.units[1] / record.units[0], A, delay
    return TruePlant(*best[1:])


def sippy(method):
    """An estimator of SIPPY."""
    from sippy_unipi import system_identification

    def estimator(log):
        y, u = log.y - log.y.mean(), log.u - log.u.mean()
        unit_y, unit_u = y.std(), u.std()
        with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if method == "ARMAX":
                model = system_identification(
                    y / unit_y, u / unit_u, method, IC="BIC", na_ord=[1, 3], nb_ord=[1, 3],
                    nc_ord=[1, 2], delays=[0, 11], max_iterations=100,
                )  # fmt: skip
                B, A = np.ravel(model.G.num[0][0]), np.ravel(model.G.den[0][0])
            else:
                past = 20 if len(u) > 300 else 12
                model = system_identification(
                    y / unit_y, u / unit_u, method, IC="AIC", SS_orders=[1, 8], SS_f=past
                )
                B, A = ss2tf(model.A, model.B, model.C, model.D)
        B = np.concatenate([np.zeros(max(len(A) - np.size(B), 0)), np.ravel(B)])
        return TruePlant(B[1:] * unit_y / unit_u, A / A[0], 0)

    return estimator


def beside(seeds):
    """Print how other estimators do on the logs."""
    methods = {"output error": output_error, "closed loop": closed_loop, "refined IV": refined_iv}
    if all(importlib.util.find_spec(name) for name in ("sippy_unipi", "tf2ss")):
        methods |= {f"SIPPY {name}": sippy(name) for name in ("N4SID", "PARSIM-K", "ARMAX")}
    results = {name: [] for name in methods}
    for count, seed in enumerate(seeds):
        log = random_log(seed)
        for name, method in methods.items():
            if "SIPPY" in name and count >= SLOW_LOGS:
                continue
            start = time.process_time()
            try:
                model = method(log)
                seconds = time.process_time() - start
                sign, error = agreement(log, model.response)
                loop = robust(model)
            except (CompensatorError, ArithmeticError, ValueError, np.linalg.LinAlgError,
                    TypeError, IndexError, AttributeError):  # fmt: skip
                results[name].append(None)
                continue
            is_bad = not sign or loop is None or not radius(log.plant, loop[0]) < 1
            results[name].append((sign, error, is_bad, seconds))
    print("method        logs refused wrong sign  bad   error median/90 %  CPU s")
    for name, rows in results.items():
        complete = [row for row in rows if row is not None]
        errors = [row[1] for row in complete] or [np.nan]
        print(f"{name:15}{len(rows):4}{len(rows) - len(complete):8}"
              f"{sum(not row[0] for row in complete):10}"
              f"{sum(row[2] for row in complete):6}   {np.median(errors):8.3f} "
              f"{np.quantile(errors, 0.9):8.2f}"
              f"{np.median([row[3] for row in complete] or [np.nan]):9.2f}")  # fmt: skip


def print_table(rows):
    out = [row for row in rows if "refused" not in row]
    refused = [row for row in rows if "refused" in row]
    ok = sum(row["oracle"] for row in rows)
    lost = sum(row["oracle"] for row in refused)
    errors = np.array([row["error"] for row in out] or [np.nan])
    theirs = np.array([row["oracle error"] for row in out] or [np.nan])
    times = np.array([row["time"] for row in rows])
    print(f"{len(rows)} logs, oracle ok {ok}; handed out {len(out)}, bad among them "
          f"{sum(row['bad'] for row in out)}; refused {len(refused)}, though oracle ok {lost} "
          f"({100 * lost / max(ok, 1):.1f} %)")  # fmt: skip
    print(f"error about the crossover: median {np.median(errors):.3f}, 90 % "
          f"{np.quantile(errors, 0.9):.2f} (oracle {np.median(theirs):.3f}, "
          f"{np.quantile(theirs, 0.9):.2f}); delay within 1: "
          f"{np.mean([abs(row['delay']) <= 1 for row in out] or [np.nan]):.2f}")  # fmt: skip
    print(f"CPU s a log with its controllers: median {np.median(times):.2f}, 90 % "
          f"{np.quantile(times, 0.9):.2f}")  # fmt: skip
    bad = sum(row["bad"] for row in out)
    if out:
        most = beta.ppf(0.95, bad + 1, len(out) - bad) if bad < len(out) else 1.0
        print(f"bad among those handed out: below {100 * most:.2f} % with 95 % (Clopper-Pearson)")
    for key in ("family", "disturbance", "excitation"):
        print(f"{key:12} logs  handed out  bad  refused  though oracle ok")
        for name in sorted({row[key] for row in rows}):
            of_name = [row for row in rows if row[key] == name]
            gone = [row for row in of_name if "refused" in row]
            print(f"  {name:10}{len(of_name):5}{len(of_name) - len(gone):12}"
                  f"{sum(row.get('bad', False) for row in of_name):5}{len(gone):9}"
                  f"{sum(row['oracle'] for row in gone):18}")  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seeds", default="50000:50300", help="A:B, from A to B - 1")
    parser.add_argument(
        "--rows", type=Path, help="write a line of JSON for each seed; seeds in FILE are not run"
    )
    parser.add_argument("--all", action="store_true", help="print every log")
    parser.add_argument("--speed", action="store_true", help="time identify_process alone")
    parser.add_argument("--beside", action="store_true", help="run other estimators, too")
    options = parser.parse_args()
    first, last = map(int, options.seeds.split(":"))
    if options.speed:
        times = [identification_time(seed) for seed in range(first, last)]
        print(f"identify_process, CPU s a log: median {np.median(times):.2f}, 90 % "
              f"{np.quantile(times, 0.9):.2f}, most {max(times):.2f}")  # fmt: skip
        return
    rows = []
    if options.rows and options.rows.exists():
        rows = [json.loads(line) for line in options.rows.read_text().splitlines()]
    finished = {row["seed"] for row in rows}
    for seed in range(first, last):
        if seed in finished:
            continue
        row = row_of(seed)
        rows.append(row)
        if options.rows:
            with options.rows.open("a") as file:
                file.write(json.dumps(row, default=float) + "\n")
        is_lost = "refused" in row and row["oracle"]
        if options.all or is_lost or row.get("bad"):
            words = row.get("refused") or f"{'BAD ' * row['bad']}sign {row['sign']}, radius " \
                f"{row['radius']:.4f}, error {row['error']:.3g}, {row['model']}"  # fmt: skip
            print(f"{seed} {row['log']}: {words[:300]}", flush=True)
    print_table(rows)
    if options.beside:
        beside(range(first, last))


if __name__ == "__main__":
    main()
