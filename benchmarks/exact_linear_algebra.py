"""Time of exact linear algebra beside SymPy's own routines, measured in one run.

Rational: the 2n x 2n Sylvester system of a pole placement, solve and determinant. SymPy's
Matrix.LUsolve and Matrix.det run at small n only, so each is timed at growing sizes while one run
stays below the budget, and its time at n is extrapolated from the last one by the factor
(n / n_0)**3: the count of arithmetic operations. The numbers themselves grow too (here linearly
with n), which is left out, in SymPy's favour. A ratio without "extrapolated" is measured.

"200 to 450 times faster than SymPy" holds against Matrix.det only. The resultant, which needs no
matrix, has faster rivals: `resultants` prints ours beside SymPy's Poly.resultant, python-flint's
own and the determinant of the Sylvester matrix, all measured, on random rationals.

Symbolic: generic determinant at n = 4, that is, the resultant of two quartics with free
coefficients, and the generic pole placement at n = 3 with free target coefficients.

    python benchmarks/exact_linear_algebra.py [--budget 20] [--seed 0]
"""

import argparse
import random
import time

import flint
import sympy

from compensator_theory import number_of_common_roots, resultant, sylvester_m, sylvester_m1
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
    return sympy.Matrix(
        sylvester_m1(list(sympy.symbols(f"a0:{n + 1}")), list(sympy.symbols(f"b0:{n + 1}")))
    )


def random_polynomial(n, rng, leading=1):
    rest = [sympy.Rational(rng.randint(-9, 9), rng.randint(1, 9)) for _ in range(n)]
    return sympy.Poly([sympy.Integer(leading), *rest], sympy.Symbol("s"), domain="QQ")


def best_of(times, function, *arguments):
    return min(timed(function, *arguments)[0] for _ in range(times))


def resultants(rng, budget):
    """Resultant and number of common roots: ours, SymPy's, python-flint's, the determinant."""
    print(f"{'resultant and gcd':<24} {'ours':>9} {'SymPy':>9} {'flint':>9} {'determinant':>12}   "
          f"{'common roots: ours':>18} {'flint gcd':>9}   seconds")  # fmt: skip
    resultant(random_polynomial(3, rng), random_polynomial(2, rng))  # warm up
    slow = False
    for n in (10, 20, 50, 100, 200):
        a, b = random_polynomial(n, rng), random_polynomial(n - 1, rng, 2)
        raw = [
            flint.fmpq_poly([flint.fmpq(int(c.p), int(c.q)) for c in reversed(p.all_coeffs())])
            for p in (a, b)
        ]
        times = {
            "ours": best_of(3, resultant, a, b),
            "sympy": float("nan") if slow else best_of(1, a.resultant, b),
            "flint": best_of(3, raw[0].resultant, raw[1]),
            "determinant": best_of(1, lambda: determinant(sylvester_m1(a, b))),  # noqa: B023
            "roots": best_of(3, number_of_common_roots, a, b),
            "gcd": best_of(3, raw[0].gcd, raw[1]),
        }
        slow = slow or times["sympy"] * 8 > budget
        assert resultant(a, b) == determinant(sylvester_m1(a, b))
        print(f"  n = {n:<18} {times['ours']:9.5f} {times['sympy']:9.5f} {times['flint']:9.5f} "
              f"{times['determinant']:12.5f}   {times['roots']:18.5f} "
              f"{times['gcd']:9.5f}")  # fmt: skip


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
    resultants(rng, arguments.budget)
    symbolic_part()


if __name__ == "__main__":
    main()
