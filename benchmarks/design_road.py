"""The road of `design` on random and textbook plants, beside what else one would try first.

200 random plants (stable, lightly damped, integrating, unstable, nonminimum-phase; time constants
of 2 to 50 samples, dead time of 0 to 10) and 30 from textbooks; the disturbance is a step, white
noise or a sinusoid, or the command is a step; sensor noise of 0.1 to 10 % of their effect; 2000
steps, one draw. Each controller meets the plant as it was given, and five others. "verdict" is what
`design` says to use of three draws on each plant of its uncertainty.

stable: the last controller, frozen, with the true plant. tail: rms of e_0 over the last quarter
over that of the fixed LQG controller that is told the disturbance (nominal plant). peak: max
abs(e_0) likewise. good: stable, tail < 2, peak < 10. Ms: of the last controller. Medians and 90 %
quantiles; "lost" is infinite.

    .venv/bin/python benchmarks/design_road.py [random plants] [first seed]

The same of plants with two inputs and outputs, and with three: lags, oscillations, integrators,
zeros outside the unit circle, outputs that run away, strong coupling; and one input weaker.

    .venv/bin/python benchmarks/design_road.py several [random plants] [first seed]
"""

import sys
import time
from collections import Counter

import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_numeric import (
    UD,
    ControllerSettings,
    FixedController,
    Harmonic,
    SimulationCase,
    Step,
    Uncertainty,
    WhiteNoise,
    cold_start,
    fir_target,
    iir,
    simulate_many,
)
from rcac_numeric.designing._closed_loop_design import settings_of
from rcac_numeric.designing._design import verdict_of
from rcac_numeric.designing._expected import read_expected
from rcac_numeric.designing._plants import Variation, read_plant, variations
from rcac_numeric.designing._reference import reference_loop
from rcac_numeric.designing._simc import simc
from rcac_numeric.designing._trials import FIXED, RCAC, Trials, measured
from rcac_numeric.targets import direction_information, modelling_information

STEPS, DRAWS = 2000, 3
KINDS = ("stable", "lightly damped", "integrating", "unstable", "nonminimum phase", "stable")
TRUE = (
    Variation(), Variation("gain x 2", gain=2), Variation("gain x 0.4", gain=0.4),
    Variation("time constants x 1.5", time=1.5), Variation("delay + 1", delay=1),
    Variation("noise x 3", noise=3),
)  # fmt: skip
SEVERAL_KINDS = ("lags", "oscillating", "integrating", "nonminimum phase", "unstable", "coupled")
ONE_INPUT = (
    Variation("input 1 x 0.6", gain=(0.6, 1.0)),
    Variation("input 1 x 0.6", gain=(0.6, 1, 1)),
)
WAYS = (
    "road, signals known", "road, size known", "fixed, signals known", "fixed, size known",
    "verdict, signals known", "verdict, size known", "SIMC", "cold_start",
    "fir_target, R_theta = 1",
)  # fmt: skip
# Transfer function, sample time and dead time in seconds.
TEXTBOOK = {
    # K. J. Astrom and T. Hagglund, Benchmark systems for PID control, IFAC PID'00 (2000).
    "(s + 1)^-2": ("1/(s + 1)**2", 0.2, 0),
    "(s + 1)^-3": ("1/(s + 1)**3", 0.3, 0),
    "(s + 1)^-4": ("1/(s + 1)**4", 0.4, 0),
    "(s + 1)^-8": ("1/(s + 1)**8", 0.8, 0),
    "four lags, 0.2": ("1/((s + 1)*(s/5 + 1)*(s/25 + 1)*(s/125 + 1))", 0.05, 0),
    "four lags, 0.5": ("1/((s + 1)*(s/2 + 1)*(s/4 + 1)*(s/8 + 1))", 0.15, 0),
    "zero at 10": ("(1 - s/10)/(s + 1)**3", 0.3, 0),
    "zero at 2": ("(1 - s/2)/(s + 1)**3", 0.3, 0),
    "zero at 1": ("(1 - s)/(s + 1)**3", 0.3, 0),
    "zero at 0.5": ("(1 - 2*s)/(s + 1)**3", 0.3, 0),
    "lag 0.1, dead time 1": ("1/(s/10 + 1)", 0.1, 1.0),
    "lag 1, dead time 1": ("1/(s + 1)", 0.2, 1.0),
    "lag 10, dead time 1": ("1/(10*s + 1)", 0.5, 1.0),
    "two lags 2, dead time 1": ("1/(2*s + 1)**2", 0.25, 1.0),
    "oscillation 1, lag": ("9/((s + 1)*(s**2 + s + 9))", 0.1, 0),
    "oscillation 3": ("9/(s**2 + s + 9)", 0.1, 0),
    "unstable": ("1/(s**2 - 1)", 0.1, 0),
    # S. Skogestad, Journal of Process Control 13 (2003): E1, E3, E7, E9, E10, E12, E13.
    "Skogestad E1": ("1/((s + 1)*(s/5 + 1))", 0.05, 0),
    "Skogestad E3": ("2*(15*s + 1)/((20*s + 1)*(s + 1)*(s/10 + 1)**2)", 0.1, 0),
    "Skogestad E7": ("(1 - 2*s)/(s + 1)**3", 0.4, 0),
    "Skogestad E9": ("1/(s + 1)**2", 0.2, 1.0),
    "Skogestad E10": ("1/((20*s + 1)*(2*s + 1))", 0.5, 1.0),
    "Skogestad E12": ("(6*s + 1)*(3*s + 1)/((10*s + 1)*(8*s + 1)*(s + 1))", 0.2, 0.2),
    "Skogestad E13": ("(2*s + 1)/((10*s + 1)*(s/2 + 1))", 0.2, 1.0),
    # The text: Rohrs (1.7), the mass-spring-damper (8.64), the converter and the cart.
    "Rohrs": ("2*229/((s + 1)*(s**2 + 30*s + 229))", 0.05, 0),
    "mass-spring-damper": ("s/(s**2 + 5*s + 10)", 0.05, 0),
    "double integrator": ("1/s**2", 0.2, 0),
    "motor position": ("1/(s*(s + 1))", 0.1, 0),
    "integrator, dead time 1": ("1/s", 0.2, 1.0),
    "unstable lag, dead time 0.2": ("1/(s - 1)", 0.05, 0.2),
}


def factor(time_constant):
    return f"({time_constant!r}*s + 1)"


def random_plant(seed):
    """Kind, transfer function in s with one step as its unit, and dead time in steps."""
    rng = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]

    def between(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    sign = rng.choice([-1.0, 1.0])
    above, below = [repr(float(sign))], []
    if kind == "stable":
        below += [factor(between(2, 40)) for _ in range(rng.integers(1, 5))]
        if len(below) > 1 and rng.random() < 0.4:
            above.append(factor(between(1, 30)))
    elif kind == "lightly damped":
        omega, damping = between(0.1, 0.8), between(0.005, 0.1)
        below.append(f"(s**2*{1 / omega**2!r} + s*{2 * damping / omega!r} + 1)")
        if rng.random() < 0.6:
            below.append(factor(between(2, 30)))
    elif kind == "integrating":
        below.append(f"s*{between(5, 40)!r}")
        below += [factor(between(2, 20)) for _ in range(rng.integers(0, 3))]
        if rng.random() < 0.2:
            below.append("20*s")
    elif kind == "unstable":
        below.append(f"({between(8, 50)!r}*s - 1)")
        below += [factor(between(2, 10)) for _ in range(rng.integers(0, 3))]
    else:
        below += [factor(between(3, 30)) for _ in range(rng.integers(2, 4))]
        above.append(f"(1 - {between(2, 15)!r}*s)")
    longest = {"unstable": 3, "lightly damped": 5}.get(kind, 10)
    late = min(int(rng.integers(0, 11)), longest) if rng.random() < 0.7 else 0
    return kind, f"{'*'.join(above)}/({'*'.join(below)})", float(late)


def plants_of(model):
    """The variations that a plant is judged on."""
    return TRUE if model.m == 1 else (*TRUE, ONE_INPUT[model.m - 2])


def random_plant_of_several(seed):
    """As `random_plant`, with two inputs and outputs or three, as rows of entries."""
    rng = np.random.default_rng([seed, 11])
    kind, m = SEVERAL_KINDS[seed % len(SEVERAL_KINDS)], 2 + seed // len(SEVERAL_KINDS) % 2

    def between(low, high):
        return float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.3g}")

    least, most = (0.6, 0.8) if kind == "coupled" else (0.0, 0.6)
    gains = rng.uniform(least, most, (m, m)) * rng.choice([-1, 1], (m, m)) / (m - 1)
    np.fill_diagonal(gains, rng.choice([-1.0, 1.0], m))
    gains *= np.outer(*(np.exp(rng.uniform(-0.5, 0.5, (2, m)))))
    entries = [[f"{gain:.3g}/({between(3, 30)!r}*s + 1)" for gain in row] for row in gains]
    i = int(rng.integers(m))
    if kind == "oscillating":
        omega, damping = between(0.1, 0.6), between(0.02, 0.2)
        lag = f"(s**2*{1 / omega**2:.4g} + s*{2 * damping / omega:.4g} + 1)"
        entries[i] = [f"{gain:.3g}/{lag}" for gain in gains[i]]
    elif kind == "integrating":
        entries[i] = [f"{gain:.3g}/(s*{between(5, 40)!r})" for gain in gains[i]]
    elif kind == "unstable":
        slow = between(8, 50)
        entries[i] = [f"{gain:.3g}/({slow!r}*s - 1)" for gain in gains[i]]
    elif kind == "nonminimum phase":
        zero, lag = between(2, 10), between(3, 20)
        entries[i] = [f"{entry}*(1 - {zero!r}*s)/({lag!r}*s + 1)" for entry in entries[i]]
    longest = {"unstable": 2, "oscillating": 3}.get(kind, 5)
    return f"{kind}, {m} x {m}", entries, float(min(int(rng.integers(0, 6)), longest))


def surroundings(model, seed):
    """(disturbance, command, noise) of one draw; sizes by what they do to y."""
    rng = np.random.default_rng([seed, 7])
    kind = ("step", "white", "sinusoid", "command")[rng.integers(4)]
    share, level = rng.choice([0.01, 0.05, 0.2]), rng.choice([0.001, 0.01, 0.1])
    omega = float(np.exp(rng.uniform(np.log(0.02), np.log(0.6))))
    low = model.low_gain
    little = WhiteNoise(float(share))
    if kind == "step":
        return kind, Step(1.0) + little, None, level * low
    if kind == "white":
        loop = reference_loop(
            model, read_expected(WhiteNoise(1.0), 1e-3 * low, None, np.inf, low)[0]
        )
        return kind, WhiteNoise(1.0), None, level * np.sqrt(loop.lqg.cost.value) * low
    if kind == "sinusoid":
        wave = Harmonic(omega, 1.0, float(rng.uniform(0, 6)))
        return kind, wave + little, None, level * float(np.linalg.norm(model.response(omega)[0], 2))
    return kind, little, Step(min(low, 1.0)), level * min(low, 1.0)


def controllers(model, known, size):
    """From the ways to controllers, or to why there is none."""
    controllers_by_name = {}
    for name, expected in (("signals known", known), ("size known", size)):
        try:
            others = variations(model, Uncertainty())
            reference = reference_loop(model, expected, np.inf, others)
            fixed = controllers_by_name[f"fixed, {name}"] = FixedController(reference.compensator)
            designed = controllers_by_name[f"road, {name}"] = settings_of(
                model, reference, expected
            )
            trials = Trials({RCAC: designed, FIXED: fixed}, model, expected, others, STEPS, DRAWS)
            use = verdict_of(trials.in_threads()).use
            controllers_by_name[f"verdict, {name}"] = designed if use == RCAC else fixed
        except CompensatorError as error:
            controllers_by_name.setdefault(f"fixed, {name}", str(error))
            controllers_by_name[f"road, {name}"] = controllers_by_name[f"verdict, {name}"] = str(
                error
            )
    if model.m > 1:
        try:
            directions = direction_information(model.servo())
            controllers_by_name["cold_start"] = cold_start(
                directions, order=len(model.A), stable=model.is_stable
            )
        except CompensatorError as error:
            controllers_by_name["cold_start"] = str(error)
        return controllers_by_name
    try:
        controllers_by_name["SIMC"] = simc(model)
    except CompensatorError as error:
        controllers_by_name["SIMC"] = str(error)
    try:
        order, directions = len(model.A), modelling_information(model.servo())
        controllers_by_name["cold_start"] = cold_start(
            directions, order=order, stable=model.is_stable
        )
        controllers_by_name[WAYS[-1]] = ControllerSettings(
            structure=iir(n_c=order + 1), target=fir_target(directions), update=UD(R_theta=1.0)
        )
    except CompensatorError as error:
        controllers_by_name["cold_start"] = controllers_by_name[WAYS[-1]] = str(error)
    return controllers_by_name


def judged(G, period, late, seed):
    """From (way, plant) to (stable, tail, peak, Ms), and what acted on the plant."""
    model = read_plant(G, period, late)
    kind, disturbance, command, noise = surroundings(model, seed)
    known, _ = read_expected(disturbance, noise, command, np.inf, model.low_gain, model.m)
    size, _ = read_expected(known.size, noise, command, np.inf, model.low_gain, model.m)
    controllers_by_name = controllers(model, known, size)
    cases, keys = [], []
    for way, controller in controllers_by_name.items():
        if isinstance(controller, str):
            continue
        for true in plants_of(model):
            w = known.w(STEPS, seed, true.noise)
            try:
                servo = model.servo(true)
            except CompensatorError:
                continue
            cases.append(SimulationCase(servo, controller, w, {"stride": STEPS}))
            keys.append((way, true.name))
    runs = simulate_many(cases, threads=1)
    measures = dict(zip(keys, (measured(run) for run in runs), strict=True))
    _, tail, peak, _ = measures.get(("fixed, signals known", "nominal"), (False, 1.0, 1.0, 1.0))
    scaled = {
        key: (stable, rms / tail, highest / peak, Ms)
        for key, (stable, rms, highest, Ms) in measures.items()
    }
    outcomes = {
        key: run.outcome for key, run in zip(keys, runs, strict=True) if key[1] == "nominal"
    }
    return scaled, kind, controllers_by_name, outcomes


def is_good(measures):
    stable, tail, peak, _ = measures
    return stable and tail < 2 and peak < 10


def failure(measures, outcome, why):
    """What kind of failure a run that is not good is."""
    if measures is None:
        return f"no controller: {why[:60]}"
    stable, tail, *_ = measures
    if outcome != "completed":
        return "the run diverged"
    if not stable:
        return "the last controller is unstable"
    return "the tail is twice as large" if tail >= 2 else "the peak is ten times as large"


def quantiles(values):
    low, high = (np.quantile(values, q, method="lower") for q in (0.5, 0.9))
    words = [f"{v:.3g}" if np.isfinite(v) else "lost" for v in (low, high)]
    return " / ".join(words)


def table(results, title, ways=WAYS, plants=TRUE):
    print(f"\n{title}: {len(results)} plants")
    print(f"{'way':26} {'plant':22} {'stable %':>8} {'good %':>7}  tail          peak         Ms")
    lost = (False, np.inf, np.inf, np.inf)
    for way in ways:
        for true in plants:
            rows = [scaled.get((way, true.name), lost) for scaled, *_ in results]
            stable = 100 * np.mean([row[0] for row in rows])
            good = 100 * np.mean([is_good(row) for row in rows])
            numbers = [quantiles([row[i] if row[0] else np.inf for row in rows]) for i in (1, 2, 3)]
            print(f"{way:26} {true.name:22} {stable:8.0f} {good:7.0f}  "
                  + "  ".join(f"{n:12}" for n in numbers))  # fmt: skip


def failures(results, names, way):
    counts, examples = Counter(), {}
    for name, (scaled, kind, controllers_by_name, outcomes) in zip(names, results, strict=True):
        measures = scaled.get((way, "nominal"))
        if measures is None or not is_good(measures):
            why = controllers_by_name[way] if isinstance(controllers_by_name[way], str) else ""
            word = failure(measures, outcomes.get((way, "nominal"), ""), why)
            word = f"{word}, {kind}"
            counts[word] += 1
            examples.setdefault(word, []).append(name)
    print(f"\nnot good, nominal, {way}:")
    for word, count in counts.most_common():
        print(f"  {count:3}  {word}: {'; '.join(examples[word][:8])}")


def main(count=200, first=50_000):
    start = time.perf_counter()
    plants = [(f"{first + i}", *random_plant(first + i)) for i in range(count)]
    results = [judged(G, 1.0, late, int(name)) for name, _, G, late in plants]
    table(results, "random plants")
    for way in WAYS[:6]:
        failures(results, [f"{name} {kind}" for name, kind, *_ in plants], way)
    for kind in dict.fromkeys(KINDS):
        rows = [r for r, plant in zip(results, plants, strict=True) if plant[1] == kind]
        shares = []
        for way in WAYS:
            measures = [scaled.get((way, "nominal")) for scaled, *_ in rows]
            share = np.mean([one is not None and is_good(one) for one in measures])
            shares.append(f"{way}: {share:.0%}")
        print(f"good, {kind}: {'; '.join(shares)}")
    book = [judged(*entry, first + i) for i, entry in enumerate(TEXTBOOK.values())]
    table(book, "textbook plants")
    for way in WAYS[:6]:
        failures(book, list(TEXTBOOK), way)
    print(f"{time.perf_counter() - start:.0f} s")


def several(count=40, first=450_000):
    start = time.perf_counter()
    plants = [(f"{first + i}", *random_plant_of_several(first + i)) for i in range(count)]
    results = [judged(G, 1.0, late, int(name)) for name, _, G, late in plants]
    ways = (*WAYS[:6], "cold_start")  # of the zero directions
    table(results, "two and three inputs and outputs", ways, (*TRUE, ONE_INPUT[0]))
    for way in ways:
        failures(results, [f"{name} {kind}" for name, kind, *_ in plants], way)
    print(f"{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    if sys.argv[1:2] == ["several"]:
        several(*map(int, sys.argv[2:]))
    else:
        main(*map(int, sys.argv[1:]))
