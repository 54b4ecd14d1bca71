"""Certified sets: tightness, families, runs inside, times of proofs, forgeries, finished runs.

    python benchmarks/certified.py tightness [loops]   greedy motion at 0.999 and 1.1 of the radius
    python benchmarks/certified.py gains               gains and limits that move beside theta
    python benchmarks/certified.py bounds [plants]     bounds of z over the largest z of runs
    python benchmarks/certified.py families [random]   sets of random and 30 textbook plants, shares
    python benchmarks/certified.py kept [plants] [draws]   RCAC without bounds, in a box, in the set
    python benchmarks/certified.py several [plants] [draws]   the same of plants with 2 x 2 channels
    python benchmarks/certified.py times               seconds of set and proof over l_theta
    python benchmarks/certified.py forged [count]      certificates of false claims that pass
    python benchmarks/certified.py runs                `certified_from` on the examples of the text

The greedy motion chooses at every step the change of theta in the set that makes x'Px largest at
the next one. Its growth a step over 3000 steps is below 1 in the set, and above 1 soon beyond it if
the set is tight. OPENBLAS_NUM_THREADS=1 makes small matrices faster.
"""

import itertools
import sys
import time
from collections import Counter, namedtuple
from dataclasses import replace
from fractions import Fraction

import attrs
import numpy as np
from design_road import TEXTBOOK, random_plant, random_plant_of_several

from compensator_theory.errors import CompensatorError, NoSolutionError
from rcac_numeric import (
    UD,
    ControllerSettings,
    Plant,
    PlantChange,
    PlantSchedule,
    SimulationCase,
    Step,
    TargetModel,
    WhiteNoise,
    certified_from,
    certified_set,
    design,
    fir,
    fir_integrator,
    iir,
    peak_bounds,
    pid,
    quasi_fir,
    simulate,
    simulate_many,
)
from rcac_numeric.analysis._certified_set import CertifiedSet
from rcac_numeric.analysis._closed_loop import frozen_loop
from rcac_numeric.analysis._moving_gains import centered_loop
from rcac_numeric.analysis._regressor_system import regressor_system, rounded_matrix
from rcac_numeric.arrays._values import replaced
from rcac_numeric.checks._diagnosis import largest_radius
from rcac_numeric.designing._closed_loop_design import settings_of
from rcac_numeric.designing._design import MOST_PROVED
from rcac_numeric.designing._plants import Variation
from rcac_numeric.designing._trials import whole_rms

STEPS = 3000
LAG = "2/(10*s + 1)"
TWO = [["1/(10*s + 1)", "0.4/(8*s + 1)"], ["0.3/(6*s + 1)", "1.2/(12*s + 1)"]]
DESIGNED = {
    "IIR": (LAG, {}),
    "IIR, dead time 5": (LAG, {"dead_time": 5.0}),
    "unstable": ("1/(20*s - 1)", {"noise": 0.01}),
    "integrating": ("1/(s*(5*s + 1))", {}),
    "nonminimum phase": ("(1 - 5*s)/((10*s + 1)*(2*s + 1))", {}),
    "PI": (LAG, {"structure": pid("PI"), "dead_time": 2.0}),
    "PID": ("1/((20*s + 1)*(3*s + 1))", {"structure": pid(), "noise": 0.005}),
    "FIR": (LAG, {"structure": fir(20), "disturbance": WhiteNoise(0.5)}),
    "FIR + integrator": (LAG, {"structure": fir_integrator(10), "dead_time": 2.0}),
    "feedforward": (LAG, {"feedforward": True, "command": Step(1.0)}),
    "2 x 2": (TWO, {}),
}
DRAWN = (
    ("IIR", iir), ("FIR", fir), ("PID", lambda n, **s: pid("PID", **s)), ("quasi-FIR", quasi_fir),
    ("FIR + integrator", fir_integrator),
)  # fmt: skip


def designed(G, options):
    """A servo loop of `design`."""
    return design(G, **{"sample_time": 1.0, "disturbance": 0.5, "noise": 0.02, "seeds": 1,
                        "steps": 300} | options)  # fmt: skip


def drawn(seed):
    """(name, plant, settings) of a standard problem that a random theta_0 stabilises."""
    rng = np.random.default_rng(seed)
    name, structure_of = DRAWN[seed % len(DRAWN)]
    l_u, l_y = ((1, 1), (1, 1), (2, 1), (1, 2), (2, 2))[seed // len(DRAWN) % 5]
    if name in ("PID", "FIR + integrator"):  # more integrators than inputs are not stabilised
        l_u = l_y
    n = int(rng.integers(l_y, 5))
    structure = structure_of(int(rng.integers(2, 5)), l_u=l_u, l_y=l_y)
    while True:
        A = rng.standard_normal((n, n))
        A *= rng.uniform(0.3, 0.97) / np.abs(np.linalg.eigvals(A)).max()
        B, C = rng.standard_normal((n, l_u)), rng.standard_normal((l_y, n))
        plant = Plant(A=A, B=B, D_1=B, C=C, E_1=C[:1])
        theta = rng.uniform(0.01, 0.5) * rng.standard_normal(structure.l_theta)
        loop = centered_loop(regressor_system(plant, structure), theta)
        if loop.spectral_radius < 0.995:
            break
    target = TargetModel([np.zeros((1, l_u)), np.ones((1, l_u))])
    settings = ControllerSettings(
        structure=structure, target=target, update=UD(R_theta=1.0), theta_0=theta
    )
    return f"{name}, {l_u} x {l_y}", plant, settings


def greedy_growth(region, share):
    """Growth a step of the greedy motion at a share of the radius."""
    member = region.members[0]
    system = regressor_system(member.plant, region.structure, region.fixed)
    P = np.array([[float(e) for e in row] for row in member.P])
    loop = centered_loop(system, region.center)
    A, B, C = loop.A, loop.B * region.input_scale, loop.C
    pull, H = B.T @ P @ A, B.T @ P @ B
    angles = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    candidates = circle if B.shape[1] == 2 else np.array([[1.0], [-1.0]])
    quadratic = np.einsum("ci,ij,cj->c", candidates, H, candidates)
    x, growth = np.random.default_rng(1).standard_normal(len(A)), 0.0
    for k in range(STEPS):
        size = share * np.linalg.norm(region.regressor_factor.T @ (C @ x))
        gain = 2 * size * candidates @ (pull @ x) + size**2 * quadratic
        x = A @ x + B @ candidates[gain.argmax()] * size
        length = np.sqrt(x @ P @ x)  # it falls at every step within the set
        growth += np.log(length) if k >= STEPS // 2 else 0.0
        x /= length
    return float(np.exp(growth / (STEPS - STEPS // 2)))


def tightness(count=50):
    """Greedy motions of every structure, servo and standard."""
    cases = []
    for name, (G, options) in DESIGNED.items():
        result = designed(G, options)
        cases.append((f"servo: {name}", result.plant, result.settings))
    cases += [(f"standard: {a}", b, c) for a, b, c in map(drawn, range(count))]
    inside, outside, failed = [], [], 0
    for name, plant, settings in cases:
        for shape in ("prior", "volume"):
            region = certified_set(plant, settings, shape=shape)
            low, high = greedy_growth(region, 0.999), greedy_growth(region, 1.1)
            peak = max(region.peaks.values())
            failed += not region.is_verified
            inside.append(low)
            outside.append(high if peak > 0.999 else np.nan)
            capped = "" if peak > 0.999 else f", bounded by the caps (norm {peak:.3f})"
            print(f"{name:36} {shape:6} l {settings.l_theta:3}: {low:.4f} {high:.4f}{capped}",
                  flush=True)  # fmt: skip
    known = np.array([v for v in outside if np.isfinite(v)])
    print(
        f"{len(inside)} sets of {len(cases)} loops, {failed} not verified; growth at 0.999: "
        f"{min(inside):.4f} to {max(inside):.4f}, {np.sum(np.array(inside) >= 1)} at 1 or more; at "
        f"1.1: {known.min():.4f} to {known.max():.4f}, {np.sum(known > 1)} of {len(known)} above 1"
    )


def hostile_growth(region, share):
    """Growth a step where theta and the gains of one input make x'Px largest at the next step."""
    member = region.members[0]
    system = regressor_system(member.plant, region.structure, region.fixed)
    P = np.array([[float(e) for e in row] for row in member.P])
    A, C, center = rounded_matrix(system.A), system.outputs, region.center
    through = rounded_matrix(system.plant_inputs)[:, 0]
    memory = system.inputs[:, 0] - through
    corners = [(v, s, g) for v in (-1, 1) for s in (region.limit_share, 1)
               for g in region.input_gain]  # fmt: skip
    v, s, g = np.array(corners).T
    x, growth = np.random.default_rng(1).standard_normal(len(A)), 0.0
    for k in range(STEPS):
        phi = C @ x
        u = s * (center @ phi + share * v * np.linalg.norm(region.regressor_factor.T @ phi))
        after = (A @ x)[:, None] + np.outer(memory, u) + np.outer(through, g * u)
        values = np.einsum("ic,ij,jc->c", after, P, after)
        length = np.sqrt(values.max())
        growth += np.log(length) if k >= STEPS // 2 else 0.0
        x = after[:, values.argmax()] / length
    return float(np.exp(growth / (STEPS - STEPS // 2)))


MOVING = {
    "gain in [0.8, 1.25]": {"input_gain": (0.8, 1.25)},
    "limits pass 0.5": {"limit_share": 0.5},
    "limits of any size": {"limit_share": 0.0},
    "gain in [0.8, 1.25], limits pass 0.7": {"input_gain": (0.8, 1.25), "limit_share": 0.7},
}


def gains():
    """Sets beside gains that move: their size, RCAC's share of the radius, hostile motions."""
    sizes = {name: [] for name in MOVING}
    for loop, (G, options) in DESIGNED.items():
        result = designed(G, options)
        if result.plant.l_u > 1:
            continue
        theta = result.runs["RCAC"].theta
        alone = certified_set(result.plant, result.settings)
        volume = np.linalg.slogdet(alone.factor)[1]
        print(f"{loop}: RCAC uses {alone.radius_of(theta).max():.2f} of the set without motion")
        for name, moving in MOVING.items():
            start = time.perf_counter()
            try:
                region = certified_set(result.plant, result.settings, **moving)
            except NoSolutionError as error:
                print(f"  {name}: none ({str(error)[:70]}...)", flush=True)
                continue
            took = time.perf_counter() - start
            size = np.exp((np.linalg.slogdet(region.factor)[1] - volume) / len(region.center))
            sizes[name].append(size)
            print(f"  {name}: linear size {size:.2f}, RCAC uses "
                  f"{region.radius_of(theta).max():.2f}, verified {region.is_verified}, growth at "
                  f"0.999 {hostile_growth(region, 0.999):.4f}, at 1.1 "
                  f"{hostile_growth(region, 1.1):.4f}, at 1.3 {hostile_growth(region, 1.3):.4f}; "
                  f"{took:.1f} s", flush=True)  # fmt: skip
    for name, values in sizes.items():
        print(f"{name}: {len(values)} sets, median linear size {np.median(values):.2f}")


def bounds(count=20, first=50_000):
    """`peak_bounds` with the share of the radius and the peaks of w that a run has."""
    plants = [(name, *loop) for name, loop in DESIGNED.items()]
    for i in range(count):
        _, G, late = random_plant(first + i)
        plants.append((f"random {i}", G, {"dead_time": late}))
    ratios = {"all of w, over the run": [], "all of w, over theta_0 held": [],
              "the disturbance alone, over theta_0 held": []}  # fmt: skip
    seconds = []
    for name, G, options in plants:
        try:
            result = designed(G, options)
            region = certified_set(result.plant, result.settings)
            run = result.runs["RCAC"]
            share = float(region.radius_of(run.theta).max())
            if not 0 < share < 0.999:
                print(f"{name}: the run uses {share:.3g} of the radius")
                continue
            peaks = np.abs(run.w).max(axis=0)
            start = time.perf_counter()
            one = peak_bounds(region, peaks, share=share)
            seconds.append(time.perf_counter() - start)
            of_d = [channel.startswith("d") for channel in result.plant.channels]
            other = peak_bounds(region, np.where(of_d, peaks, 0.0), share=share)
        except CompensatorError as error:
            print(f"{name}: {str(error)[:80]}")
            continue
        largest = np.abs(run.z).max(axis=0)
        values = (one.z / largest, one.z / one.held, other.z / other.held)
        for words, value in zip(ratios, values, strict=True):
            ratios[words].append(float(value.max()))
        shown = ", ".join(f"{words} {values[-1]:.2f}" for words, values in ratios.items())
        print(f"{name}: l {len(region.center)}, share {share:.3f}, bound for {shown}, "
              f"{one.is_verified}, {seconds[-1]:.1f} s", flush=True)  # fmt: skip
    for words, values in ratios.items():
        low, middle, high = np.quantile(values, [0, 0.5, 1])
        print(f"{len(values)} loops, {words}: median {middle:.2f}, {low:.2f} to {high:.0f}")
    print(f"seconds: median {np.median(seconds):.1f}, {max(seconds):.1f} at most")


def road(count, first=50_000):
    """(name, G, dead time, sample time) of random plants, then of those of textbooks."""
    plants = [(f"random {i}", *random_plant(first + i)[1:], 1.0) for i in range(count)]
    return plants + [(name, G, late, h) for name, (G, h, late) in TEXTBOOK.items()]


def families(count=55):
    """Sets of the plants of `design` with their uncertainties, and the share that RCAC uses."""
    shares, nominal_shares, seconds, refused = [], [], [], []
    for name, G, late, h in road(count):
        try:
            result = design(G, sample_time=h, dead_time=late, disturbance=Step(1.0), seeds=1,
                           steps=1000)  # fmt: skip
        except CompensatorError as error:
            refused.append(f"{name}: no design: {error}")
            continue
        l_theta = result.settings.l_theta
        if l_theta > MOST_PROVED:
            refused.append(f"{name}: l_theta = {l_theta}, left out")
            continue
        start = time.perf_counter()
        try:
            region = certified_set(result.plant, result.settings, uncertainty=result.family)
        except CompensatorError as error:
            refused.append(f"{name}: {error}")
            continue
        seconds.append(time.perf_counter() - start)
        alone = certified_set(result.plant, result.settings)
        theta = result.runs["RCAC"].theta
        shares.append(float(region.radius_of(theta).max()))
        nominal_shares.append(float(alone.radius_of(theta).max()))
        print(f"{name}: l {l_theta}, {len(region.members)} plants, {seconds[-1]:.2f} s, share "
              f"{shares[-1]:.3g}, nominal set {nominal_shares[-1]:.3g}", flush=True)  # fmt: skip
    for line in refused:
        print("REFUSED", line)
    for words, values in (("family", shares), ("nominal", nominal_shares)):
        middle, high = np.quantile(values, [0.5, 0.9])
        print(f"{words}: {len(values)} sets, share of the radius median {middle:.3g}, 90 % "
              f"{high:.3g}, {np.sum(np.array(values) < 1)} runs inside")  # fmt: skip
    print(f"{len(refused)} refused; seconds: median {np.median(seconds):.2f}, {max(seconds):.1f}")


PRIORS = (1.0, 0.1, 0.01, 0.001)
BOUNDS = ("none", "box", "certified")
KeptRun = namedtuple("KeptRun", "plant kind case draw prior way lost rms radius bounded")


def cases_of(result, draws, steps):
    """(kind, name, plant, w, sign of the target) of the runs of a design.

    "family": the plants of the proof; "signals": the nominal plant, and what acts on it is hostile,
    or the target has the wrong sign, which the proof covers; "plants": others, which it does not.
    """
    model, servo = result.model, result.plant
    plants = {"nominal": servo, **result.family}
    twice, later = (model.servo(v) for v in (Variation(gain=2.0), Variation(delay=2)))
    changed = PlantSchedule([PlantChange(start=0, plant=servo),
                             PlantChange(start=steps // 2, plant=twice)])  # fmt: skip
    for i in range(draws):
        w = result.expected.w(steps, 90_000 + i)
        for name, plant in plants.items():
            yield "family", name, plant, w, 1
        noise, of_d = np.zeros_like(w), [c.startswith("d") for c in servo.channels]
        noise[:, of_d] = np.random.default_rng(i).standard_normal((steps, sum(of_d)))
        loud = w + 2 * result.expected.disturbance_size * noise
        yield "signals", "noise of d", servo, loud, 1
        yield "signals", "wrong sign of H", servo, w, -1
        yield "plants", "gain x 2 from the middle on", changed, w, 1
        yield "plants", "delay + 2", later, w, 1


def is_lost(run):
    """Whether the run ended early, or its last controller is unstable with its last plant."""
    if run.outcome != "completed":
        return True
    plant = run.plant.changes[-1].plant if isinstance(run.plant, PlantSchedule) else run.plant
    return not frozen_loop(plant, run.compensator, 0).is_stable


def rows_of(result, draws, steps=2000):
    """(kind, case, draw, prior, way, lost, rms, radius, at the boundary) of runs of a design."""
    settings, region = result.settings, result.certified
    box = settings_of(result.model, result.reference, result.expected).bounds
    ways = {"none": None, "box": box}
    if isinstance(region, CertifiedSet):
        ways["certified"] = region.bounds
    turned = replaced(settings.target, numerator=-settings.target.numerator)
    runs, keys = [], []
    for i, (kind, name, plant, w, sign) in enumerate(cases_of(result, draws, steps)):
        options = {"stride": 50}
        runs.append(SimulationCase(plant, result.fixed, w, options))
        keys.append((kind, name, i, 1.0, "fixed"))
        for prior in PRIORS:
            for way, bounds in ways.items():
                update = UD(R_theta=settings.update.R_theta * prior)
                target = settings.target if sign > 0 else turned
                one = attrs.evolve(settings, update=update, target=target, bounds=bounds)
                runs.append(SimulationCase(plant, one, w, options))
                keys.append((kind, name, i, prior, way))
    for key, run in zip(keys, simulate_many(runs), strict=True):
        radius = largest_radius(run)
        yield (*key, is_lost(run), whole_rms(run), radius, radius is not None and run.bounded > 0)


def print_kept(rows, words):
    """Lost runs, mean and worst rms over the fixed controller's, by prior and way."""
    fixed = {(r.plant, r.draw): r for r in rows if r.way == "fixed"}
    print(
        f"\n{words}: {len({r.plant for r in rows})} plants. Lost runs, mean rms over fixed, worst"
    )
    for prior, way in [(1.0, "fixed"), *itertools.product(PRIORS, BOUNDS)]:
        cells = []
        for kind in ("family", "signals", "plants"):
            group = [r for r in rows if (r.kind, r.prior, r.way) == (kind, prior, way)]
            pairs = [(r, fixed[r.plant, r.draw]) for r in group]
            ratios = [a.rms / b.rms for a, b in pairs if not (a.lost or b.lost)]
            if ratios:
                lost, mean = sum(r.lost for r in group), np.exp(np.mean(np.log(ratios)))
                cells.append(f"{kind} {lost:4} of {len(group):4}, {mean:6.3f}, {max(ratios):8.3g}")
        if cells:
            print(f"prior x {prior:<5g} {way:9} | {' | '.join(cells)}")


def compare_bounds(count=85, draws=3):
    """Runs of RCAC without bounds, in the box and in the set, beside the fixed controller."""
    plants = road(55)
    indices = np.unique(np.linspace(0, len(plants) - 1, count).astype(int))
    print_runs([plants[i] for i in indices], draws)


def several(count=20, draws=3, first=450_000):
    """The same of random plants with two inputs and two outputs, of each kind in turn.

    Without dead time: each step of it adds 8 coefficients, and `design` proves up to MOST_PROVED.
    """
    drawn_plants = map(random_plant_of_several, itertools.count(first))
    square = ((kind, G) for kind, G, _ in drawn_plants if len(G) == 2)
    plants = [(f"{i} {kind}", G, 0.0, 1.0)
              for i, (kind, G) in enumerate(itertools.islice(square, count))]  # fmt: skip
    print_runs(plants, draws)


def print_runs(plants, draws):
    """Design each (name, G, dead time, sample time), run it and print what was lost."""
    rows, without = [], []
    for name, G, late, h in plants:
        start = time.perf_counter()
        try:
            result = design(G, sample_time=h, dead_time=late, disturbance=1.0, kept="certified",
                            seeds=1, steps=200)  # fmt: skip
        except CompensatorError as error:
            print(f"{name}: no design: {str(error)[:80]}", flush=True)
            continue
        new = [KeptRun(name, *row) for row in rows_of(result, draws)]
        proved = isinstance(result.certified, CertifiedSet)
        (rows if proved else without).extend(new)
        lost = Counter(r.way for r in new if r.kind == "family" and r.lost)
        reason = "" if proved else f"no set: {result.certified[:120]}; "
        print(f"{name}: l_theta {result.settings.l_theta}, family of {1 + len(result.family)}, "
              f"{reason}{len(new)} runs, lost of the family {dict(lost)}, "
              f"{time.perf_counter() - start:.0f} s", flush=True)  # fmt: skip
    print(f"\n{len(rows) + len(without)} runs")
    if rows:
        print_kept(rows, "Plants with a set")
    if without:
        print_kept(without, "Plants without a set")
    inside = [r for r in rows if r.way == "certified"]
    for prior in PRIORS if inside else ():
        group = [r for r in inside if r.kind == "family" and r.prior == prior]
        middle, high = np.quantile([r.radius for r in group], [0.5, 0.9])
        share = np.mean([r.bounded for r in group])
        print(f"prior x {prior:g}, family: share of the radius median {middle:.3g}, 90 % {high:.3g}"
              f", at the boundary {share:.0%} of the runs")  # fmt: skip
    if inside:
        radius = max(r.radius for r in inside)
        print(f"largest radius of {len(inside)} runs: 1 - {1 - radius:.2g}")


def times():
    """Seconds of the set and of its verification."""
    for late in (0.0, 2.0, 6.0, 12.0, 18.0):
        result = designed("1/(10*s + 1)", {"dead_time": late, "steps": 100})
        for uncertainty in (None, result.family):
            start = time.perf_counter()
            region = certified_set(result.plant, result.settings, uncertainty=uncertainty)
            seconds = time.perf_counter() - start
            start = time.perf_counter()
            verified = region.is_verified
            took = time.perf_counter() - start
            print(f"l_theta {len(region.center)}, {len(region.members)} plants: set and proof "
                  f"{seconds:.2f} s, verification {took:.3f} s, "
                  f"{verified}", flush=True)  # fmt: skip


def forgeries(region, rng):
    """Yield (kind, forged set) whose claim is false or whose P is none."""
    member = region.members[0]
    n = len(member.P)
    i, j = rng.integers(n, size=2)
    rows = [list(row) for row in member.P]
    if i == j:
        rows[i][i] = -rows[i][i]
    else:
        rows[i][j] += Fraction(1, 2**200)
    yield "P", replace(region, members=(replace(member, P=tuple(map(tuple, rows))),))
    factor = float(rng.choice([1.0002, 1.001, 1.1, 10.0]))
    yield "factor", replace(region, regressor_factor=region.regressor_factor * factor)
    name = str(rng.choice(["A", "B", "C"]))
    matrix = np.array(getattr(member.plant, name))
    index = tuple(rng.integers(size) for size in matrix.shape)
    matrix[index] += float(rng.choice([0.01, 0.1, -0.01, -0.1]))
    other = replaced(member.plant, exact=None, **{name: matrix})
    yield "plant", replace(region, members=(replace(member, plant=other),))
    center = np.array(region.center)
    center[rng.integers(len(center))] += float(rng.choice([0.01, 0.1, -0.01, -0.1]))
    yield "center", replace(region, center=center)
    yield "rate", replace(region, rate=float(rng.choice([0.999, 0.99, 0.5])))


def forged(count=500):
    """Forged certificates: those of false claims must be refused."""
    passed, tried, true = 0, {}, 0
    seed = 0
    while sum(tried.values()) < count:
        _, plant, settings = drawn(seed)
        region = certified_set(plant, settings)
        for kind, forgery in forgeries(region, np.random.default_rng(seed)):
            if kind != "P" and max(forgery.peaks.values()) <= 1:
                true += 1  # the changed claim is true, and P may prove it
                continue
            tried[kind] = tried.get(kind, 0) + 1
            passed += forgery.is_verified
        seed += 1
    print(f"{tried} forged certificates of {seed} sets, {passed} accepted; {true} changes left the "
          "claim true")  # fmt: skip


def runs(steps=2000):
    """`certified_from` on the first run of each example with one adaptive controller."""
    from rcac_experiments.dissertation import load_example
    from rcac_experiments.dissertation._examples import example_ids

    after, seconds, proofs = [], [], 0
    for identifier in example_ids():
        specifications = [
            s
            for s in load_example(identifier).runs.values()
            if type(s.settings) is ControllerSettings
        ]
        if not specifications:
            continue
        one = specifications[0]
        w = np.asarray(one.cases()[0].w)[:steps]
        run = simulate(one.plant, one.settings, w, saturation=one.saturation)
        start = time.perf_counter()
        tail = certified_from(run)
        seconds.append(time.perf_counter() - start)
        if tail.k0 is None:
            print(f"{identifier}: {tail.reason}")
            continue
        verified = tail.is_verified
        proofs += verified
        begin = max(one.settings.k_w, tail.start)
        after.append((tail.k0 - begin, tail.earliest - begin))
        print(f"{identifier}: l {run.theta.shape[1]}, control from {one.settings.k_w}, proved from "
              f"{tail.k0}, no set before {tail.earliest}, {verified}, {seconds[-1]:.2f} s",
              flush=True)  # fmt: skip
    steps_after, possible = np.array(after).T
    print(f"{len(after)} of {len(seconds)} runs, {proofs} verified: median "
          f"{np.median(steps_after):.0f} steps after control begins, {min(steps_after)} to "
          f"{max(steps_after)}; no set before {np.median(possible):.0f} (median), "
          f"at most 2 steps later in {np.sum(steps_after - possible <= 2)}; "
          f"{np.median(seconds):.2f} s (median), {max(seconds):.0f} at most")  # fmt: skip


COMMANDS = {
    f.__name__: f
    for f in (tightness, gains, bounds, families, compare_bounds, several, times, forged, runs)
}


if __name__ == "__main__":
    name, *numbers = sys.argv[1:] or ["tightness"]
    COMMANDS[name](*map(int, numbers))
