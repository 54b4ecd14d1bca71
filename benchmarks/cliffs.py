"""The sizes that people bring: seconds of processor time of each row, before and after.

Run with: python benchmarks/cliffs.py [ROW ...] [--before PYTHON] [--repeats 3] [--limit 60]
          python benchmarks/cliffs.py --table

A row is a call of a public function on data of the kind that was found slow. `--before` names the
interpreter of another environment, in which an older state is installed: both take turns, each in a
process of its own and after one call that is not counted, and the medians are printed. A row that
takes longer than the limit is printed as such. OpenBLAS keeps its threads, which are a part of what
is measured; OPENBLAS_NUM_THREADS=1 leaves them out.

`--table` prints the table of the sizes that were slow when they were first measured: those seconds,
today's and the aim.

A row more is a function under `@row` that returns the call.
"""

from __future__ import annotations

import argparse
import json
import random
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

Call = Callable[[], Any]


@dataclass(frozen=True)
class Row:
    """What is called, and the seconds that it is to take at most."""

    call: Callable[[], Call]
    aim: float


ROWS: dict[str, Row] = {}
LOOPS = ("random", "modes", "chain", "lags", "delays")


def row(aim: float) -> Callable[[Callable[[], Call]], Callable[[], Call]]:
    """Enter a function under its name, with its aim in seconds."""

    def entered(make: Callable[[], Call]) -> Callable[[], Call]:
        ROWS[make.__name__] = Row(make, aim)
        return make

    return entered


def _integers(count: int, seed: str, largest: int = 9) -> list[int]:
    drawn = random.Random(seed)
    return [1, *(drawn.randint(-largest, largest) for _ in range(count))]


def _loop(function: str, family: str, n: int) -> Call:
    import sympy

    import compensator_theory as exact

    s, z = sympy.symbols("s z")
    half = sympy.Rational(1, 2)
    if family == "random":
        N, D = (sympy.Poly(_integers(m, f"{m}"), s) for m in (n - 2, n))
    elif family == "chain":
        N, D = sympy.Poly(1, s), sympy.Poly(sympy.prod([s + k for k in range(n)]), s)
    elif family == "lags":
        N, D = sympy.Poly(2, s), sympy.Poly((s + 1) ** n, s)
    elif family == "delays":
        N, D = sympy.Poly(half / 25, z), sympy.Poly((z - 49 * half / 25) * z ** (n - 1), z)
    else:  # lightly damped modes, driven and measured at one place
        N, D = sympy.Poly(1, s), sympy.Poly(s * (s + 1), s)
        for k in range((n - 2) // 2):
            w, c = sympy.Rational(10 + 7 * k, 5), sympy.Rational(1 + k % 9, 200)
            D *= sympy.Poly(s**2 + 2 * c * w * s + w**2, s)
            if k:
                w -= half
                N *= sympy.Poly(s**2 + 2 * c * w * s + w**2, s)
    loop = exact.transfer_function((N, D))
    return lambda: getattr(exact, function)(loop, feedback=-1)


for _function, _size, _aim in (
    ("stability_margins", 40, 1.0), ("root_locus", 24, 0.2), ("stabilising_gains", 40, 0.7),
):  # fmt: skip
    for _family in LOOPS:
        _call = partial(_loop, _function, _family, _size)
        ROWS[f"{_function}_{_family}_{_size}"] = Row(_call, _aim)


@row(aim=1.0)
def lqg_poles_32() -> Call:
    import sympy

    import compensator_theory as exact

    drawn, n = random.Random("lqg_poles"), 32
    A, B, C = (
        [[drawn.randint(-3, 3) for _ in range(columns)] for _ in range(rows)]
        for rows, columns in ((n, n), (n, 1), (1, n))
    )
    eye = sympy.eye(n).tolist()
    plant = exact.lqg_problem((A, B, C), eye, [[1]], eye, [[1]], variable="s")
    return lambda: exact.lqg_poles(plant)


@row(aim=1.0)
def frobenius_form_80() -> Call:
    from compensator_theory.forms import frobenius_form

    drawn, n = random.Random("frobenius_form"), 80
    A = [[drawn.randint(-3, 3) for _ in range(n)] for _ in range(n)]
    return lambda: frobenius_form(A)


@row(aim=1.0)
def solve_care_heat_100() -> Call:
    """The heat flow of CAREX 18."""
    import numpy as np

    from rcac_numeric import solve_riccati

    n = 100
    A = 0.01 * (n + 1) ** 2 * (np.eye(n, k=1) - 2 * np.eye(n) + np.eye(n, k=-1))
    x = np.arange(1, n + 1) / (n + 1)
    B = ((x >= 0.2) & (x <= 0.3)).astype(float)[:, None]
    C = ((x >= 0.5) & (x <= 0.6)).astype(float)[None] / n
    return lambda: solve_riccati(A, B, C.T @ C, np.eye(1), time="continuous")


def _dead_time(steps: int) -> Call:
    import control

    from rcac_numeric import stability_margins

    loop = control.tf([0.004], [1, -0.995] + [0] * steps, 0.1)
    return lambda: stability_margins(loop, feedback=-1)


@row(aim=0.2)
def margins_of_dead_time_90() -> Call:
    return _dead_time(90)


@row(aim=0.2)
def margins_of_dead_time_100() -> Call:
    return _dead_time(100)


@row(aim=0.2)
def margins_of_a_plant_with_dead_time_90() -> Call:
    """The delay stands between the plant's lag and the compensator."""
    from rcac_numeric import Compensator, stability_margins, standard_plant

    plant = standard_plant("0.004/(q**90*(q - 0.995))")
    compensator = Compensator(past_u=[[[-0.1]]], past_y=[[[0.0]], [[-1.0]]])
    return lambda: stability_margins((plant, compensator))


@row(aim=10.0)
def brunovsky_form_100() -> Call:
    from compensator_theory import brunovsky_form

    drawn, n = random.Random("brunovsky_form"), 100
    A, B = (
        [[drawn.randint(-9, 9) for _ in range(columns)] for _ in range(n)] for columns in (n, 1)
    )
    return lambda: brunovsky_form(A, B)


@row(aim=5.0)
def stability_conditions_4x4_16_symbols() -> Call:
    """The double inverted pendulum under state feedback, a question to SymPy (28010)."""
    import sympy

    import compensator_theory as exact

    I_L, I_T, d_L, d_T, m_L, m_T, leg, g = sympy.symbols(
        "I_L I_T d_L d_T m_L m_T l g", positive=True
    )
    K = sympy.Matrix(2, 4, lambda i, j: sympy.Symbol(f"k_{i}{j}"))
    coupling, lever = I_T + m_T * (d_T**2 + d_T * leg), g * d_T * m_T
    mass = sympy.Matrix([
        [I_L + I_T + d_L**2 * m_L + m_T * (d_T + leg) ** 2, coupling],
        [coupling, I_T + d_T**2 * m_T],
    ])  # fmt: skip
    gravity = sympy.Matrix([[g * (d_L * m_L + (d_T + leg) * m_T), lever], [lever, lever]])
    lower = (mass.inv() * (gravity - K[:, :2])).row_join(-mass.inv() * K[:, 2:])
    A = sympy.zeros(2).row_join(sympy.eye(2)).col_join(lower)
    plant = exact.realisation((A, sympy.Matrix([0, 0, 0, 1]), sympy.Matrix([[1, 0, 0, 0]])), "s")
    polynomial = plant.characteristic_polynomial
    return lambda: exact.stability_conditions(polynomial)


@row(aim=5.0)
def stability_conditions_6x6_10_symbols() -> Call:
    """Two mechanical modes at a cavity with two loss rates and a direct coupling."""
    import sympy

    import compensator_theory as exact

    w_1, w_2, g_1, g_2, G_1, G_2, k_1, k_2, D, J = sympy.symbols(
        "w_1 w_2 g_1 g_2 G_1 G_2 k_1 k_2 D J", positive=True
    )
    A = [
        [0, w_1, 0, 0, 0, 0], [-w_1, -g_1, J, 0, G_1, 0],
        [0, 0, 0, w_2, 0, 0], [J, 0, -w_2, -g_2, G_2, 0],
        [0, 0, 0, 0, -k_1, D], [G_1, 0, G_2, 0, -D, -k_2],
    ]  # fmt: skip
    plant = exact.realisation((A, [[0]] * 5 + [[1]], [[1, 0, 0, 0, 0, 0]]), "s")
    polynomial = plant.characteristic_polynomial
    return lambda: exact.stability_conditions(polynomial)


@row(aim=1.0)
def cost_of_lqg_3_two_outputs() -> Call:
    """The exact cost, or the refusal that names its enclosure and then that."""
    import compensator_theory as exact
    from compensator_theory.errors import BudgetError

    plant = exact.lqg_problem(
        ([[1, -1, -1], [2, 0, 2], [2, 2, -1]], [[0], [2], [2]], [[0, 1, 1], [2, -1, 2]]),
        [[3, 2, "5/2"], [2, 6, -1], ["5/2", -1, "17/4"]], [["13/3"]],
        [["21/4", 3, 0], [3, "21/4", "3/2"], [0, "3/2", "5/4"]], [[1, 0], [0, 1]],
        variable="z",
    )  # fmt: skip

    def call() -> object:
        controller = exact.lqg_controller(plant)
        try:
            return controller.cost
        except BudgetError:
            return controller.cost_enclosure

    return call


@row(aim=2.0)
def h_infinity_norm_12_states_15_digits() -> Call:
    import sympy

    import compensator_theory as exact

    drawn, s = random.Random("h_infinity_norm"), sympy.Symbol("s")
    above, below = sympy.Poly(1, s), sympy.Poly(1, s)
    for k in range(6):
        for side in (0, 1):
            real, imaginary = (
                sympy.Rational(drawn.randint(10**14, 10**15 - 1), 10**14) for _ in range(2)
            )
            factor = sympy.Poly(s**2 + real / (8 - 7 * side) * s + imaginary**2, s)
            if side:
                above = above * factor if k else above
            else:
                below *= factor
    plant = exact.transfer_function((above, below))
    return lambda: exact.h_infinity_norm(plant)


TABLE: list[tuple[str, str, list[str]]] = [
    ("stability_conditions, 4x4 with 16 symbols", "> 100", ["stability_conditions_4x4_16_symbols"]),
    ("stability_conditions, 6x6 with 10 symbols", "51", ["stability_conditions_6x6_10_symbols"]),
    ("cost of LQG, discrete, n = 3, 2 outputs", "> 50", ["cost_of_lqg_3_two_outputs"]),
    ("h_infinity_norm, 12 states, 15 digits", "20", ["h_infinity_norm_12_states_15_digits"]),
    ("stability_margins, exact n = 40", "5.4", [f"stability_margins_{f}_40" for f in LOOPS]),
    ("stability_margins, numeric with z^-90", "3.5", ["margins_of_dead_time_90"]),
    ("root_locus, n = 24", "1.8", [f"root_locus_{f}_24" for f in LOOPS]),
    ("stabilising_gains, n = 40", "3.5", [f"stabilising_gains_{f}_40" for f in LOOPS]),
    ("lqg_poles, n = 32", "4.5", ["lqg_poles_32"]),
    ("frobenius_form, n = 80", "refused", ["frobenius_form_80"]),
    ("solve_care, n = 100 (CAREX 18)", "16", ["solve_care_heat_100"]),
]
"""What was slow, its seconds when it was first measured, and its rows; the slowest one counts."""


def table(repeats: int, limit: float) -> None:
    """Print the table: the largest median of the rows of each line."""
    print(f"{'':44}{'before':>10}{'now':>10}{'aim':>8}")
    for subject, before, names in TABLE:
        medians: list[float] = []
        failures: list[str] = []
        for name in names:
            times = _child_seconds(sys.executable, name, repeats, limit)
            if isinstance(times, str):
                failures.append(times)
            else:
                medians.append(median(times))
        now = failures[0] if failures else f"{max(medians):.2f}"
        print(f"{subject:44}{before:>10}{now:>10}{ROWS[names[0]].aim:>8.2g}", flush=True)


def _timed(name: str, repeats: int) -> list[float]:
    """Seconds of processor time of calls after a first one, of which SymPy remembers nothing."""
    times = []
    ROWS[name].call()()
    from sympy import CRootOf
    from sympy.core.cache import clear_cache

    for _ in range(repeats):
        call = ROWS[name].call()
        clear_cache()
        CRootOf.clear_cache()
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return times


def _child_seconds(python: str, name: str, repeats: int, limit: float) -> str | list[float]:
    """The seconds by another process, or why there are none."""
    command = [python, __file__, name, "--child", "--repeats", str(repeats)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return f"over {limit:g}"
    if done.returncode:
        return done.stderr.strip().splitlines()[-1].split(":")[0].split(".")[-1]
    times: list[float] = json.loads(done.stdout)
    return times


def main() -> None:
    reader = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    reader.add_argument("rows", nargs="*", help="all that contain one of these words")
    reader.add_argument(
        "--before", help="a Python interpreter in whose environment the old state is"
    )
    reader.add_argument("--repeats", type=int, default=3)
    reader.add_argument("--limit", type=float, default=60.0, help="seconds for a row")
    reader.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    reader.add_argument("--table", action="store_true", help="what was slow, before and now")
    options = reader.parse_args()
    if options.table:
        table(options.repeats, options.limit)
        return
    if options.child:
        print(json.dumps(_timed(options.rows[0], options.repeats)))
        return
    chosen = [n for n in ROWS if not options.rows or any(word in n for word in options.rows)]
    pythons = [python for python in (options.before, sys.executable) if python]
    print(f"{'':32}" + "".join(f"{'before' if p == options.before else 'now':>14}" for p in pythons)
          + f"{'aim':>8}")  # fmt: skip
    for name in chosen:
        shown = []
        for python in pythons:
            times = _child_seconds(python, name, options.repeats, options.limit)
            shown.append(times if isinstance(times, str) else f"{median(times):.3f}")
        print(f"{name:32}" + "".join(f"{s:>14}" for s in shown) + f"{ROWS[name].aim:8.2g}",
              flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
