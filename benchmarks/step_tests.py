"""Step tests of known plants: coverage of intervals, wrong answers, refusals; two-point fits.

First and second order, oscillating, integrating with and without a lag, and four equal lags, of
either sign, from an operating point; 120 to 1000 rows, one to three moves of u; the disturbance is
white, coloured, a random walk, a drift, a level jump or rounding, or the record ends early. The
noise is 0.01 to 0.1 of the response.

*Wrong*: the sign, or a gain more than three standard deviations (interval/3.92) away. The two-point
method takes 28.3 and 63.2 % of the response, the mean of the last tenth for the final value.

    .venv/bin/python benchmarks/step_tests.py [--seeds A:B] [--rows FILE]

Seeds 5000 to 5204 by default: 2 s each. Of the gain the interval is of its kind: a lag that is
taken for an integrator, or the reverse, has none.
"""

import argparse
import json
import time
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from compensator_theory.errors import CompensatorError
from rcac_numeric.identification import identify_output_error, identify_step_response

FAMILIES = ("first", "second", "oscillating", "integrating", "integrating with lag", "four lags")
DISTURBANCES = ("white", "white", "coloured", "walk", "drift", "jump", "rounding", "early end")


@dataclass
class Test:
    """A record and the truth; times in steps."""

    def __str__(self):
        return (
            f"K {self.gain:.4g} L {self.dead_time:.4g} T {self.lags} zeta {self.damping:.3g} omega "
            f"{self.omega:.3g} noise {self.noise:.3g} rows {len(self.u)}"
        )

    family: str
    disturbance: str
    u: np.ndarray
    y: np.ndarray
    gain: float
    dead_time: float
    lags: tuple
    damping: float
    omega: float
    noise: float

    @property
    def residence(self):
        """L and all lags."""
        if self.family == "oscillating":
            return self.dead_time + 2 * self.damping / self.omega
        return self.dead_time + sum(self.lags)


def step_of(test, t):
    """The response of gain 1 to a unit step at 0, by partial fractions or their limits."""
    t = np.maximum(t - test.dead_time, 0.0)
    if test.family == "oscillating":
        zeta, omega = test.damping, test.omega
        fast = omega * np.sqrt(1 - zeta**2)
        wave = np.cos(fast * t) + zeta * omega / fast * np.sin(fast * t)
        return 1 - np.exp(-zeta * omega * t) * wave
    if test.family == "integrating":
        return t
    T = test.lags[0]
    if test.family == "integrating with lag":
        return t - T * (1 - np.exp(-t / T))
    if test.family == "first":
        return 1 - np.exp(-t / T)
    if test.family == "second":
        T_2 = test.lags[1]
        return 1 - (T * np.exp(-t / T) - T_2 * np.exp(-t / T_2)) / (T - T_2)
    x = t / T
    return 1 - np.exp(-x) * (1 + x + x**2 / 2 + x**3 / 6)


def test_of(seed):
    """The record of a seed."""
    rng = np.random.default_rng(seed)
    family = FAMILIES[seed % len(FAMILIES)]
    disturbance = str(rng.choice(DISTURBANCES))
    T = float(np.exp(rng.uniform(np.log(6), np.log(60))))
    lags = {"first": (T,), "second": (T, T * rng.uniform(0.1, 0.8)), "integrating with lag": (T,),
            "four lags": (T / 2,) * 4}.get(family, ())  # fmt: skip
    L = float(rng.choice([0.4, T * rng.uniform(0.05, 1.0), T * rng.uniform(0.2, 2.0)]))
    test = Test(
        family, disturbance, None, None, float(np.exp(rng.uniform(-3, 3)) * rng.choice([-1, 1])), L,
        lags, float(rng.uniform(0.1, 0.7)), 1 / float(np.exp(rng.uniform(np.log(4), np.log(20)))),
        float(np.exp(rng.uniform(np.log(0.01), np.log(0.1)))),
    )  # fmt: skip
    longest = test.residence if family != "oscillating" else L + 2 / (test.damping * test.omega)
    if family == "integrating":
        longest = L + 20
    before = int(rng.integers(5, 40))
    moves = int(rng.integers(1, 4))
    each = int(max(longest * rng.uniform(4, 8), 60 / moves))
    if disturbance == "early end":
        moves, each = 1, int(max(longest * rng.uniform(1.2, 2.5), 60))
    rows = before + moves * each
    t = np.arange(rows)
    height = float(np.exp(rng.uniform(-2, 2)))
    u, y = np.zeros(rows), np.zeros(rows)
    for move in range(moves):
        size = height * (1, -1, 1)[move] * (1 if move == 0 else rng.uniform(0.5, 1.0))
        at = before + move * each
        u[at:] += size
        y += size * step_of(test, t - at)
    response = float(np.ptp(y))
    noise = rng.standard_normal(rows)
    if disturbance == "coloured":
        noise = lfilter([np.sqrt(1 - 0.8**2)], [1, -0.8], noise)
    y = test.gain * (y + response * test.noise * noise)
    size = abs(test.gain) * response
    if disturbance == "walk":
        y = y + size * 0.1 * test.noise * np.cumsum(rng.standard_normal(rows))
    if disturbance == "drift":
        y = y + size * rng.uniform(-0.5, 0.5) * t / rows
    if disturbance == "jump":
        y = y + size * rng.uniform(-0.4, 0.4) * (t > rng.integers(before, rows))
    y = y + size * rng.uniform(-20, 20)
    if disturbance == "rounding":
        quantum = size * rng.uniform(0.01, 0.1)
        y = quantum * np.round(y / quantum)
    test.u, test.y = u + height * rng.uniform(-5, 5), y
    return test


def two_point(test):
    """Gain, time constant and dead time by 28.3 and 63.2 % of the first response."""
    moved = np.nonzero(np.diff(test.u))[0] + 1
    end = moved[1] if len(moved) > 1 else len(test.u)
    start, y = test.y[: moved[0]].mean(), test.y[moved[0] : end]
    final = y[-max(len(y) // 10, 1) :].mean()
    part = (y - start) / (final - start)
    times = [int(np.argmax(part >= share)) for share in (0.283, 0.632)]
    T = 1.5 * (times[1] - times[0])
    gain = (final - start) / (test.u[moved[0]] - test.u[0])
    return gain, T, max(times[1] - T, 0.0)


def covers(true, low, high):
    """Whether an interval holds the true value; a rounding of it is allowed."""
    return low - 1e-9 * abs(true) <= true <= high + 1e-9 * abs(true)


def measured(test, seed):
    """What is found about a test: a mapping."""
    begun = time.process_time()
    row = {"seed": seed, "family": test.family, "disturbance": test.disturbance}
    try:
        step = identify_step_response(test.u, test.y)
    except CompensatorError as error:
        return row | {"refused": str(error), "seconds": time.process_time() - begun}
    row |= {"seconds": time.process_time() - begun, "kind": step.kind, "step": str(step)}
    low, high = step.gain_interval
    integrates = step.kind.startswith("integrating")
    row["integrates as it is"] = integrates == test.family.startswith("integrating")
    row["wrong sign"] = bool(step.gain * test.gain < 0)
    if row["integrates as it is"]:
        row["gain"] = covers(test.gain, low, high)
        row["3 sd"] = not covers(
            test.gain, step.gain - 3 * (step.gain - low) / 1.96,
            step.gain + 3 * (high - step.gain) / 1.96,
        )  # fmt: skip
        row["gain error"] = abs(step.gain / test.gain - 1)
        row["residence time"] = covers(test.residence, *step.residence_time[1:])
        row["residence error"] = abs(step.residence_time[0] / test.residence - 1)
        if test.family != "four lags":
            row["dead time"] = covers(test.dead_time, *step.dead_time_interval)
            row["dead time error"] = abs(step.dead_time - test.dead_time) / test.residence
        for i, (true, one) in enumerate(zip(test.lags, step.time_constants, strict=False)):
            if test.family != "four lags":
                row[f"T{i + 1}"] = covers(true, *one[1:])
        if test.family == "oscillating" and step.damping is not None:
            row["damping"] = covers(test.damping, *step.damping[1:])
            row["omega"] = covers(test.omega, *step.natural_frequency[1:])
    return row


def others(test):
    """Errors of the two-point method and of the output error fit."""
    row = {}
    if not test.family.startswith("integrating"):
        gain, T, L = two_point(test)
        row["two-point gain"] = abs(gain / test.gain - 1)
        row["two-point residence"] = abs((T + L) / test.residence - 1)
        row["two-point dead time"] = abs(L - test.dead_time) / test.residence
        row["two-point sign"] = gain * test.gain < 0
    try:
        model = identify_output_error(test.u, test.y)
    except CompensatorError:
        return row | {"output error refused": True}
    past = np.exp(-0.3j / test.residence)
    B, A = model.transfer_function
    G = np.polyval(B, 1 / past) / np.polyval(A, 1 / past) * past**model.delay
    s = 0.3j / test.residence
    true = complex(test.gain * np.exp(-s * test.dead_time))
    if test.family == "oscillating":
        true /= (s / test.omega) ** 2 + 2 * test.damping * s / test.omega + 1
    else:
        true /= np.prod([T * s + 1 for T in test.lags])
    true /= s if test.family.startswith("integrating") else 1
    row["output error sign"] = bool(np.real(G / true) < 0)
    row["output error response"] = float(abs(G / true - 1))
    return row


def share(rows, name):
    """Those true of those that have it, as text."""
    values = [row[name] for row in rows if name in row]
    return f"{sum(values)} of {len(values)} ({100 * np.mean(values):.1f} %)" if values else "-"


def quantiles(rows, name):
    """Median and 90 %."""
    values = [row[name] for row in rows if name in row]
    return f"{np.median(values):.2g}, {np.quantile(values, 0.9):.2g}" if values else "-"


def printed(rows):
    """Print the tables."""
    handed = [row for row in rows if "refused" not in row]
    wrong = [row for row in handed if row["wrong sign"] or row.get("3 sd")]
    signs = sum(row["wrong sign"] for row in handed)
    count = f"{len(rows)} records: handed out {len(handed)}, refused {len(rows) - len(handed)}"
    print(f"{count}, wrong {len(wrong)} (sign {signs})")
    print("integrating told from settling:", share(handed, "integrates as it is"))
    for name in ("gain", "residence time", "dead time", "T1", "T2", "damping", "omega"):
        print(f"95 % intervals, {name}: {share(handed, name)}")
    groups = [("family", FAMILIES), ("disturbance", tuple(dict.fromkeys(DISTURBANCES)))]
    for key, names in groups:
        for name in names:
            alike = [row for row in rows if row[key] == name]
            kinds = ("gain", "dead time", "T1")
            covered = ", ".join(f"{one} {share(alike, one)}" for one in kinds)
            print(
                f"  {name}: refused {sum('refused' in r for r in alike)} of {len(alike)}, {covered}"
            )
    for name in ("gain error", "residence error", "dead time error", "two-point gain",
                 "two-point residence", "two-point dead time", "output error response",
                 "seconds"):  # fmt: skip
        print(f"{name}, median and 90 %: {quantiles(rows, name)}")
    print("two-point method, wrong sign:", share(rows, "two-point sign"))
    print("identify_output_error, wrong sign:", share(rows, "output error sign"), "refused:",
          sum("output error refused" in row for row in rows))  # fmt: skip


def main():
    """Print the tables of the seeds."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", default="5000:5204")
    parser.add_argument("--rows", type=argparse.FileType("w"), help="write one line of JSON a seed")
    arguments = parser.parse_args()
    rows = []
    for seed in range(*map(int, arguments.seeds.split(":"))):
        test = test_of(seed)
        rows.append(measured(test, seed) | others(test))
        if arguments.rows:
            print(json.dumps(rows[-1] | {"truth": str(test)}, default=float), file=arguments.rows,
                  flush=True)  # fmt: skip
    printed(rows)


if __name__ == "__main__":
    main()
