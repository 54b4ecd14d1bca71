"""Time of exact linear algebra beside SymPy's own routines, measured in one run.

Rational: the 2n x 2n Sylvester system of a pole placement, solve and determinant. SymPy's
Matrix.LUsolve and Matrix.det run at small n only, so each is timed at growing sizes while one run
stays below the budget, and its time at n is extrapolated from the last one by the factor
(n / n_0)**3: the count of arithmetic operations. The numbers themselves grow too (here linearly
with n), which is left out, in SymPy's favour. A ratio without "extrapolated" is measured.

Symbolic: generic determinant at n = 4, that is, the resultant of two quartics with free
coefficients, and the generic pole placement at n = 3 with free target coefficients.

    python benchmarks/exact_linear_algebra.py [--budget 20] [--seed 0]
"""

import argparse
import random
import time

import sympy

from compensator_theory import sylvester_m
from compensator_theory.matrices.linear_algebra import determinant, solve

SIZES = (50, 100)
TRIED = (5, 10, 20, 30, 40, 50, 100)


def timed(function, *arguments):
    start = time.perf_counter()
    result = function(*arguments)
    return time.perf_counter() - start, result


def sylvester_system(n, rng):
    """Random rationals with numerators up to 9 and denominators up to 9, n_c = n."""

    def rational():
        return sympy.Rational(rng.randint(-9, 9), rng.randint(1, 9))

    D = [sympy.Integer(1)] + [rational() for _ in range(n)]
    N = [rational() or sympy.Integer(1)] + [rational() for _ in range(n - 1)]
    right = sympy.Matrix([rational() for _ in range(2 * n)])
    return sympy.Matrix(sylvester_m(D, N, n, n - 1)), right


def rational_part(name, ours, theirs, budget, rng):
    measured = {}
    for n in TRIED:
        seconds, _ = timed(theirs, *sylvester_system(n, rng))
        measured[n] = seconds
        following = [m for m in TRIED if m > n]
        if not following or seconds * (following[0] / n) ** 4 > budget:
            break
    for n in SIZES:
        system = sylvester_system(n, rng)
        best = min(timed(ours, *system)[0] for _ in range(3))
        last = max(m for m in measured if m <= n)
        sympys = measured[last] * (n / last) ** 3
        how = "measured" if last == n else f"extrapolated from {measured[last]:.2f} s at n = {last}"
        print(
            f"{name:<24} n = {n:<4} ours {best:8.4f} s   SymPy {sympys:9.2f} s ({how})   "
            f"ratio {sympys / best:8.0f}"
        )


def symbolic_system(n):
    a = sympy.symbols(f"a0:{n}")
    b = sympy.symbols(f"b0:{n}")
    t = sympy.symbols(f"t0:{2 * n}")
    M = sylvester_m([sympy.Integer(1), *a], list(b), n, n - 1)
    return sympy.Matrix(M), sympy.Matrix(t)


def symbolic_resultant(n):
    from compensator_theory import sylvester_m1

    return sympy.Matrix(
        sylvester_m1(list(sympy.symbols(f"a0:{n + 1}")), list(sympy.symbols(f"b0:{n + 1}")))
    )


def symbolic_part():
    matrix = symbolic_resultant(4)
    determinant(symbolic_resultant(2))  # warm up
    ours = min(timed(determinant, matrix)[0] for _ in range(3))
    sympys, _ = timed(lambda: matrix.det(method="berkowitz"))
    print(
        f"{'generic determinant':<24} n = 4    ours {ours:8.4f} s   SymPy {sympys:9.2f} s "
        f"(measured, berkowitz)   ratio {sympys / ours:8.1f}   target 0.2 s"
    )
    system = symbolic_system(3)
    ours = min(timed(solve, *system)[0] for _ in range(3))
    sympys, _ = timed(lambda: system[0].LUsolve(system[1]))
    print(
        f"{'generic solve':<24} n = 3    ours {ours:8.4f} s   SymPy {sympys:9.2f} s "
        f"(measured, unsimplified)   ratio {sympys / ours:8.1f}   target 0.5 s"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--budget", type=float, default=20.0, help="seconds for one SymPy run")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    print("Times fall with faster machines; read the ratios. Target for the rational ones: 100.")
    rational_part("rational solve", solve, lambda M, r: M.LUsolve(r), arguments.budget, rng)
    rational_part(
        "rational determinant", lambda M, _: determinant(M), lambda M, _: M.det(),
        arguments.budget, rng,
    )  # fmt: skip
    symbolic_part()


if __name__ == "__main__":
    main()
