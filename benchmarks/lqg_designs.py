"""Random LQG designs: how many are exact, each substituted, against 60-digit Riccati solutions.

`python benchmarks/lqg_designs.py [NUMBER] [SEED] [EVERY]` prints one line for each kind of design;
every EVERY-th design is compared with the solutions in 60 digits, which take most of the time.
"""

import random
import statistics
import sys
import time
from collections import Counter

import mpmath

from compensator_theory import CompensatorError, StandardProblem, lqg_controller

DIGITS = 60


def drawn(rng, rows, columns):
    return [[rng.randint(-3, 3) for _ in range(columns)] for _ in range(rows)]


def design(rng):
    """A plant of order 1 to 4 in either time, with hidden stable modes, delays, several signals."""
    variable = rng.choice("sz")
    n, several = rng.randint(1, 4), rng.random() < 0.3
    l_u, l_y = (rng.randint(1, 2), rng.randint(1, 2)) if several else (1, 1)
    A = drawn(rng, n, n)
    B, C = drawn(rng, n, l_u), drawn(rng, l_y, n)
    kind = "several signals" if several else "one signal"
    if rng.random() < 0.25:  # a filter that colours the noise
        half = "-1/2" if variable == "s" else "1/2"
        A = [[*row, rng.randint(-2, 2)] for row in A] + [[0] * n + [half]]
        B, C, n = [*B, [0] * l_u], [[*row, 0] for row in C], n + 1
        kind += ", hidden mode"
    if variable == "z" and rng.random() < 0.25:  # u is delayed
        A = [[*row, *b] for row, b in zip(A, B, strict=True)] + [
            [0] * (n + l_u) for _ in range(l_u)
        ]
        B = [[0] * l_u for _ in range(n)] + [[int(i == j) for j in range(l_u)] for i in range(l_u)]
        C, n = [[*row, *[0] * l_u] for row in C], n + l_u
        kind += ", delay"
    weighted = variable == "s" or rng.random() < 0.5
    E_1 = drawn(rng, l_u, n)
    D_1 = drawn(rng, n, l_y)
    E_2, D_2 = [[0] * l_u for _ in E_1], [[0] * l_y for _ in range(l_y)]
    if weighted:
        E_1 += [[0] * n for _ in range(l_u)]
        E_2 += [[int(i == j) for j in range(l_u)] for i in range(l_u)]
        D_1 = [[*row, *[0] * l_y] for row in D_1]
        D_2 = [[*[0] * l_y, *(int(i == j) for j in range(l_y))] for i in range(l_y)]
    plant = StandardProblem(A, B, C, D_1, None, D_2, E_1, E_2, None, variable=variable)
    return f"{'continuous' if variable == 's' else 'discrete'}, {kind}", plant


def matrix(values):
    return mpmath.matrix(
        [[mpmath.mpf(int(x.p)) / int(x.q) for x in row] for row in values.tolist()]
    )


def solved(side, start):
    """Newton's iteration (Kleinman, Hewer) from our gain, rounded to three digits, in 60 digits."""
    A, B, Q, R, N = (matrix(m) for m in (side.A, side.B, side.Q, side.R, side.N))
    _n, discrete = A.rows, side.factor.time == "discrete"
    K = mpmath.matrix(start)
    for _ in range(60):
        closed = A + B * K
        right = Q + N * K + (N * K).T + K.T * R * K
        P = lyapunov(closed, right, discrete)
        weight, row = R, B.T * P
        if discrete:
            weight, row = R + row * B, row * A
        new = -(mpmath.inverse(weight) * (row + N.T))
        if mpmath.mnorm(new - K) <= mpmath.mpf(10) ** (-DIGITS - 5) * (1 + mpmath.mnorm(new)):
            return P
        K = new
    return None


def lyapunov(A, Q, discrete):
    n = A.rows
    M, right = mpmath.zeros(n * n), mpmath.zeros(n * n, 1)
    for i in range(n):
        for j in range(n):
            row = i * n + j
            right[row] = -Q[i, j]
            if discrete:
                M[row, row] -= 1
                for k in range(n):
                    for l in range(n):  # noqa: E741
                        M[row, k * n + l] += A[k, i] * A[l, j]
            else:
                for k in range(n):
                    M[row, k * n + j] += A[k, i]
                    M[row, i * n + k] += A[k, j]
    column = mpmath.lu_solve(M, right)
    return mpmath.matrix([[column[i * n + j] for j in range(n)] for i in range(n)])


def agreement(side):
    """The largest relative difference to 60 digits; None where the iteration found nothing."""
    start = [
        [mpmath.mpf(mpmath.nstr(mpmath.mpf(int(c.centre.p)) / int(c.centre.q), 12)) for c in row]
        for row in side.K_enclosure
    ]
    try:
        P = solved(side, start)
    except ZeroDivisionError:
        return None
    if P is None:
        return None
    scale = max(abs(x) for x in P) or 1
    mine = [mpmath.mpf(int(c.centre.p)) / int(c.centre.q) for row in side.P_enclosure for c in row]
    return max(abs(a - b) for a, b in zip(mine, P, strict=True)) / scale


def main(number: int, seed: int, every: int) -> None:
    rng = random.Random(seed)
    rows: dict[str, Counter] = {}
    seconds, worst = {}, {}
    done = 0
    with mpmath.workdps(DIGITS + 20):
        while done < number:
            kind, plant = design(rng)
            row = rows.setdefault(kind, Counter())
            begin = time.process_time()
            try:
                controller = lqg_controller(plant, digits=DIGITS)
            except CompensatorError as error:
                row[f"no LQG ({type(error).__name__})"] += 1
                continue
            seconds.setdefault(kind, []).append(time.process_time() - begin)
            done += 1
            sides = controller.regulator, controller.estimator
            row["designs"] += 1
            row["gains exact"] += controller.is_exact
            row["gains rational"] += controller.is_rational
            row["certified"] += all(
                s.certificate is not None and s.certificate.holds for s in sides
            )
            row["formula"] += not controller.is_exact and all(s.formula is not None for s in sides)
            row["one field"] += controller.matrices_in_field is not None
            for side in sides:
                assert all(0 in entry for line in side.residual for entry in line)
                if done % every:
                    continue
                gap = agreement(side)
                row["compared"] += gap is not None
                if gap is not None:
                    worst[kind] = max(worst.get(kind, 0), gap)
    for kind, row in sorted(rows.items()):
        refused = {k: v for k, v in row.items() if k.startswith("no LQG")}
        counts = {k: v for k, v in row.items() if k not in refused}
        print(f"{kind}: {counts}; refused {refused or 'none'}")
        if kind in seconds:
            gap = mpmath.nstr(worst.get(kind, mpmath.nan), 2)
            times = seconds[kind]
            print(f"    largest difference {gap}, median {statistics.median(times):.3f} s, "
                  f"largest {max(times):.1f} s")  # fmt: skip
    total = sum((row for row in rows.values()), Counter())
    print({k: v for k, v in total.items() if not k.startswith("no LQG")})


if __name__ == "__main__":
    main(*(int(x) for x in (*sys.argv[1:], *("200", "1", "1")[len(sys.argv) - 1 :])))
