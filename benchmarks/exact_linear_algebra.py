"""Exact linear algebra beside the best call of SymPy and python-flint, on the same work in one run.

Rational: resultant, number of common roots, gcd with its identity, numbers of real roots and of
roots in the half planes (flint isolates them), characteristic polynomial, solve and determinant of
the 2n x 2n Sylvester system of a pole placement, and the placement itself, where the peers are
handed the finished system, or the polynomials, and have only to solve it. The product of two
transfer functions is also timed with python-control, in floats; nothing else of python-control's
can be compared, as its floats are of no use from n = 15 on.

Ours and the peers take turns, the processor time of each turn is taken, and the medians are
compared: so the last columns hold on a busy machine too. The peers of the first are handed their
own rings and keep the answer there; "by hand" is flint for somebody who has the data of SymPy and
wants the answer in SymPy, as ours gives it, converted by the public calls of both and nothing
checked. The bar is 1.5, against the one or the other; what is above both is marked. A peer that
would take more than the budget is left out at larger n.

What ours has more than the peers' bare call does not grow with n: reading lists, budget, and the
classes of SymPy that hold the answer, 0.03 to 0.1 ms for a transfer function or a placement. What
it verifies is small beside that: one product of n + 1 for the transfer function of (A, B, C); a
placement's certificate is evaluated when it is asked for.

Then to_control() at n = 100, whose check has to end within a second, and data with one, two and
three symbols, where the bar is 2, with nothing remembered of the call before. There the peers begin
and end in their own rings, and ours in SymPy's expressions; the last column holds ours against
peers that read the same expressions and write theirs. Of a resultant flint takes less than half a
millisecond, and SymPy's expression of a hundred terms alone takes more: only that column is a
comparison of the same work.

    python benchmarks/exact_linear_algebra.py [--budget 20] [--seed 0] [--sizes 10 50 100]
    python benchmarks/exact_linear_algebra.py --sizes 200 --works solve gcd
"""

import argparse
import random
import time
import warnings
from math import prod
from statistics import median

import flint
import sympy
from sympy import QQ
from sympy.polys.matrices import DomainMatrix
from sympy.polys.matrices.normalforms import smith_normal_decomp

from compensator_theory import (
    Realisation,
    TransferFunction,
    bezout_identity,
    brunovsky_form,
    count_roots,
    is_controllable,
    place_poles,
    regulator_gain,
    resultant,
    solve_lyapunov,
)
from compensator_theory.bezout import number_of_common_roots, sylvester_m
from compensator_theory.forms import kronecker_form, smith_form
from compensator_theory.matrices._flint_matrices import to_flint
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    solve,
)
from compensator_theory.matrices._rational_functions import in_symbols
from compensator_theory.roots import number_of_real_roots

S = sympy.Symbol("s")
WHO = ("ours", "sympy", "flint", "control", "by hand")
TURNS, SHORTEST = 9, 0.002  # turns of each call, and the least processor time of one
MORE_TURNS = 31  # of calls below a millisecond, which other programs disturb more


def seconds_of(call, repetitions):
    start = time.process_time()
    for _ in range(repetitions):
        call()
    return (time.process_time() - start) / repetitions


def medians(calls):
    """Median processor time of each call; all take turns, and slow ones fewer."""
    once = {who: seconds_of(call, 1) for who, call in calls.items()}
    slowest = max(once.values())
    turns = 1 if slowest > 10 else 3 if slowest > 1 else TURNS if slowest > 0.001 else MORE_TURNS
    repetitions = {who: max(1, int(SHORTEST / max(t, 1e-6))) for who, t in once.items()}
    times = {who: [] for who in calls}
    for _ in range(turns):
        for who, call in calls.items():
            times[who].append(seconds_of(call, repetitions[who]))
    return {who: median(values) for who, values in times.items()}


def median_seconds(function, *arguments):
    return medians({"it": lambda: function(*arguments)})["it"]


def random_polynomial(n, rng, leading=1):
    rest = [sympy.Rational(rng.randint(-9, 9), rng.randint(1, 9)) for _ in range(n)]
    return sympy.Poly([sympy.Integer(leading), *rest], S, domain="QQ")


def with_roots(roots):
    return prod((sympy.Poly(S - r, S, domain="QQ") for r in roots), start=sympy.Poly(1, S))


def read_polynomial(poly):
    return flint.fmpq_poly([flint.fmpq(int(c.p), int(c.q)) for c in reversed(poly.all_coeffs())])


def read_matrix(matrix):
    return flint.fmpq_mat(*matrix.shape, [flint.fmpq(int(e.p), int(e.q)) for e in matrix])


def written(number):
    return sympy.Rational(int(number.p), int(number.q))


def written_polynomial(poly):
    return sympy.Poly(list(map(written, reversed(poly.coeffs()))), S, domain="QQ")


def written_matrix(matrix):
    return sympy.ImmutableMatrix(matrix.nrows(), matrix.ncols(), list(map(written, matrix)))


def works(n, rng):
    """Yield name and calls: ours, and those of the peers, of each the best that it has."""
    a, b = random_polynomial(n, rng), random_polynomial(n - 1, rng, 2)
    A, B = map(to_flint_polynomial, (a, b))
    yield "resultant", {
        "ours": lambda: resultant(a, b), "sympy": lambda: a.resultant(b),
        "flint": lambda: A.resultant(B),
        "by hand": lambda: written(read_polynomial(a).resultant(read_polynomial(b))),
    }  # fmt: skip
    yield "common roots", {
        "ours": lambda: number_of_common_roots(a, b), "sympy": lambda: a.gcd(b),
        "flint": lambda: A.gcd(B),
        "by hand": lambda: read_polynomial(a).gcd(read_polynomial(b)).degree(),
    }  # fmt: skip
    yield "gcd and identity", {
        "ours": lambda: bezout_identity(a, b), "sympy": lambda: a.gcdex(b),
        "flint": lambda: A.xgcd(B),
        "by hand": lambda: [*map(written_polynomial, read_polynomial(a).xgcd(read_polynomial(b)))],
    }  # fmt: skip
    yield "real roots", {
        "ours": lambda: number_of_real_roots(a), "sympy": a.count_roots,
        "flint": A.numer().complex_roots,
    }  # fmt: skip
    yield (
        "half planes",
        {"ours": lambda: count_roots(a, time="continuous"), "flint": A.numer().complex_roots},
    )
    square = sympy.ImmutableMatrix(n, n, lambda *_: rng.randint(-9, 9))
    domain, integers = square.to_DM(), [int(entry) for entry in square]
    yield "characteristic polynomial", {
        "ours": lambda: characteristic_polynomial(square, S), "sympy": domain.charpoly,
        "flint": lambda: flint.fmpz_mat(n, n, integers).charpoly(),
        "by hand": lambda: written_polynomial(read_matrix(square).charpoly()),
    }  # fmt: skip
    yield from gains(n, rng)
    yield from matrices(n, rng)
    yield from systems(n, rng, a, b)
    G, H = TransferFunction(b, a), TransferFunction(random_polynomial(n - 1, rng), a)
    floats, symbols = [g.to_control() for g in (G, H)], [g.to_sympy() for g in (G, H)]
    yield "product of two systems", {
        "ours": lambda: G * H, "sympy": (symbols[0] * symbols[1]).doit,
        "control": lambda: floats[0] * floats[1],
    }  # fmt: skip


def gains(n, rng):
    """The gain of one input and controllability, from lists of integers; flint's with one row."""
    rows = [[rng.randint(-9, 9) for _ in range(n)] for _ in range(n)]
    column = [[rng.randint(-9, 9)] for _ in range(n)]
    goal = sympy.Poly([1, *(rng.randint(-9, 9) for _ in range(n))], S, domain="QQ")
    descending = [int(c) for c in goal.all_coeffs()]

    def krylov():
        a, columns = flint.fmpz_mat(rows), [flint.fmpz_mat(column)]
        for _ in range(n - 1):
            columns.append(a * columns[-1])
        return a, flint.fmpz_mat([[c[i, 0] for i in range(n)] for c in columns])

    def ackermann():
        a, kalman = krylov()
        last = flint.fmpz_mat([[int(i == n - 1)] for i in range(n)])
        row, below = kalman.solve(last).transpose().numer_denom()
        value = row * descending[0]
        for c in descending[1:]:
            value = value * a + row * c
        return value, below

    def reached():
        return krylov()[1].rank()

    def shown():
        value, below = ackermann()
        return written_matrix(flint.fmpq_mat(value) / below)

    yield "gain", {
        "ours": lambda: regulator_gain(rows, column, goal), "flint": ackermann, "by hand": shown,
    }  # fmt: skip
    yield "controllability", {
        "ours": lambda: is_controllable(rows, column), "flint": reached,
    }  # fmt: skip


def matrices(n, rng):
    """A Lyapunov equation, by flint as a Kronecker system; a realisation; and a Smith form."""
    rows = [[rng.randint(-9, 9) for _ in range(n)] for _ in range(n)]
    if n <= 10:
        A, one = flint.fmpq_mat(flint.fmpz_mat(rows)), range(n)

        def kronecker():
            whole = flint.fmpq_mat(n * n, n * n)
            for i in one:
                for j in one:
                    for k in one:
                        whole[i * n + j, k * n + j] += A[i, k]
                        whole[i * n + j, i * n + k] += A[j, k]
            return whole.solve(flint.fmpq_mat(n * n, 1, [-int(i == j) for i in one for j in one]))

        eye = [[int(i == j) for j in one] for i in one]
        yield "Lyapunov equation", {
            "ours": lambda: solve_lyapunov(rows, eye), "flint": kronecker,
            "by hand": lambda: written_matrix(kronecker()),
        }  # fmt: skip
    column, row = [[rng.randint(-9, 9)] for _ in range(n)], [[rng.randint(-9, 9) for _ in range(n)]]

    def leverrier():
        a, v, c = flint.fmpz_mat(rows), flint.fmpz_mat(column), flint.fmpz_mat(row)
        p, b, columns = a.charpoly(), flint.fmpz_mat(column), []
        for k in range(n):
            columns.append((c * v)[0, 0])
            v = a * v + b * p[n - 1 - k]
        return columns, p

    def shown():
        columns, p = leverrier()
        return [
            sympy.Poly(list(map(int, descending)), S, domain="QQ")
            for descending in (columns, reversed(p.coeffs()))
        ]

    yield "transfer function of (A, B, C)", {
        "ours": lambda: Realisation(rows, column, row).transfer_function(), "flint": leverrier,
        "by hand": shown,
    }  # fmt: skip
    if n <= 10:
        entries = [
            [sympy.Poly([rng.randint(-3, 3) for _ in range(3)], S) for _ in "ab"] for _ in "ab"
        ]
        matrix = sympy.Matrix([[e.as_expr() for e in r] for r in entries])
        domain = matrix.to_DM(QQ[S]).to_dense()
        yield "Smith form with U, V, 2 x 2", {
            "ours": lambda: smith_form(matrix, S), "sympy": lambda: smith_normal_decomp(domain),
            "by hand": lambda: [
                part.to_Matrix() for part in smith_normal_decomp(matrix.to_DM(QQ[S]).to_dense())
            ],
        }  # fmt: skip


def systems(n, rng, a, b):
    M = sylvester_m(a.all_coeffs(), b.all_coeffs(), n + 1, n - 1)
    right = sympy.ImmutableMatrix(random_polynomial(2 * n, rng).all_coeffs())
    raw, raw_column = to_flint(M), to_flint(right)
    field, column = (x.to_DM().to_field().to_dense() for x in (M, right))
    yield "solve", {
        "ours": lambda: solve(M, right), "sympy": lambda: field.lu_solve(column),
        "flint": lambda: raw.solve(raw_column),
        "by hand": lambda: written_matrix(read_matrix(M).solve(read_matrix(right))),
    }  # fmt: skip
    yield "determinant", {
        "ours": lambda: determinant(M), "sympy": field.det, "flint": raw.det,
        "by hand": lambda: written(read_matrix(M).det()),
    }  # fmt: skip
    for kind, D, N, T in (
        ("dense", a, b, random_polynomial(2 * n, rng)),
        ("integer roots", *integer_roots(n)),
    ):
        D, N, T = (p.set_domain("QQ") for p in (D, N, T))  # noqa: PLW2901
        G = TransferFunction(N, D)
        matrix = to_flint(sylvester_m(D.all_coeffs(), N.all_coeffs(), n + 1, n - 1))
        goal = to_flint(sympy.ImmutableMatrix(T.all_coeffs()))
        calls = {"ours": lambda G=G, T=T: place_poles(G, polynomial=T, feedback=-1)}
        calls["flint"] = lambda matrix=matrix, goal=goal: matrix.solve(goal)
        calls["by hand"] = lambda equation=(D, N, T): [
            *map(written_polynomial, by_sylvester(*map(read_polynomial, equation)))
        ]
        yield f"placement, {kind}", calls
        raw = tuple(map(to_flint_polynomial, (D, N, T)))
        calls["flint"] = lambda raw=raw: by_euclid(*raw)
        calls["by hand"] = lambda equation=(D, N, T): [
            *map(written_polynomial, by_euclid(*map(read_polynomial, equation)))
        ]
        yield f"placement, {kind}, xgcd", calls


def by_euclid(D, N, T):
    """The same through flint's extended Euclidean algorithm."""
    y = (T * N.xgcd(D)[1]) % D
    return (T - N * y) // D, y


def by_sylvester(D, N, T):
    """The same by the Sylvester system of the coefficients, in flint alone."""
    n = D.degree()
    columns = [[*[0] * k, *p.coeffs()] for p in (D, N) for k in range(n + (p is D))]
    matrix = flint.fmpq_mat([c + [0] * (2 * n + 1 - len(c)) for c in columns]).transpose()
    solution = matrix.solve(flint.fmpq_mat(2 * n + 1, 1, T.coeffs())).entries()
    return flint.fmpq_poly(solution[: n + 1]), flint.fmpq_poly(solution[n + 1 :])


def integer_roots(n):
    """Plant and target whose numbers are long, as Wilkinson's are."""
    halves = (sympy.Rational(2 * k + 1, 2) for k in range(1, n))
    quarters = (sympy.Rational(k, 4) for k in range(-2 * n, 0))
    return with_roots(range(1, n + 1)), with_roots(halves), with_roots(quarters)


def compare(sizes, budget, rng, chosen):
    print(heading("work"))
    last = {}
    for n in sizes:
        for name, calls in works(n, rng):
            if chosen and not any(part in name for part in chosen):
                continue
            for peer in list(calls):
                before, size = last.get((name, peer), (0.0, n))
                if peer != "ours" and before * (n / size) ** 4 > budget:
                    del calls[peer]
            seconds = medians(calls)
            last.update({(name, peer): (t, n) for peer, t in seconds.items()})
            print(line(name, n, seconds), flush=True)


def heading(works):
    names = " ".join(f"{who:>11}" for who in WHO)
    return f"{works:<30}{'n':>4} {names}   ours / best / by hand   seconds"


def line(name, n, seconds, bar=1.5):
    """A row: the medians, ours over the best peer, and over the best with SymPy on both sides."""
    rivals = [t for who, t in seconds.items() if who not in ("ours", "by hand")]
    shown = [f"{seconds[w]:11.6f}" if w in seconds else f"{'-':>11}" for w in WHO]
    ratio = seconds["ours"] / min(rivals) if rivals else 0.0
    same = seconds["ours"] / seconds["by hand"] if "by hand" in seconds else ratio
    mark = "  ABOVE" if min(ratio, same) > bar else ""
    return f"{name:<30}{n:>4} {' '.join(shown)}   {ratio:11.2f} {same:9.2f}{mark}"


def check_part(n, rng):
    """Time the check of to_control() where it is easy and where rounding is fatal."""
    random_plant = random_polynomial(n, rng), random_polynomial(n - 1, rng, 2)
    for kind, (D, N, T) in {
        "dense": (*random_plant, random_polynomial(2 * n, rng)),
        "stable target": (*random_plant, integer_roots(n)[2]),
        "integer roots": integer_roots(n),
        "integer roots, dense target": (*integer_roots(n)[:2], random_polynomial(2 * n, rng)),
    }.items():
        D, N, T = (p.set_domain("QQ") for p in (D, N, T))  # noqa: PLW2901
        placed = place_poles(TransferFunction(N, D), polynomial=T, feedback=-1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            print(f"to_control() at n = {n}, {kind}: {seconds_of(placed.to_control, 1):.3f} s")


def symbolic_works(count, rng):
    """Yield name, calls for data with so many symbols, and what the peers take with expressions.

    In the first the peers begin and end in their own rings; in the second they are handed what ours
    is handed, and give what ours gives: polynomials and matrices of SymPy.
    """
    names = "abc"[:count]
    symbols = [sympy.Symbol(name) for name in names]

    def coefficient():
        return sum((rng.randint(-3, 3) * x for x in symbols), sympy.Integer(rng.randint(1, 9)))

    p, q = (sympy.Poly([1, *(coefficient() for _ in range(4))], S) for _ in "pq")
    context = flint.fmpq_mpoly_ctx.get(["s", *names], flint.Ordering.lex)

    def read(poly):
        return context.from_dict({
            (*power, *monomial): flint.fmpq(int(c.numerator), int(c.denominator))
            for power, value in poly.set_domain(QQ[symbols]).rep.to_dict().items()
            for monomial, c in value.items()
        })  # fmt: skip

    def by_flint():
        resultant = read(p).resultant(read(q), "s")
        terms = {
            tuple(map(int, k[1:])): QQ(int(c.p), int(c.q)) for k, c in resultant.to_dict().items()
        }
        return sympy.Poly.from_dict(terms, *symbols, domain=QQ).as_expr()

    raw = [read(part) for part in (p, q)]
    yield "resultant of quartics", {
        "ours": lambda: resultant(p, q), "sympy": lambda: p.resultant(q),
        "flint": lambda: raw[0].resultant(raw[1], "s"),
    }, {"sympy": lambda: p.resultant(q), "flint": by_flint}  # fmt: skip
    D = sympy.Poly([1, *(coefficient() for _ in range(3))], S)
    N = sympy.Poly([coefficient() for _ in range(3)], S)
    T = sympy.Poly([1, *(coefficient() for _ in range(5))], S)
    M = sylvester_m(D.all_coeffs(), N.all_coeffs(), 3, 2)

    def solved():
        left, right = system()
        return left.lu_solve(right).to_Matrix()

    def system():
        right = sympy.Matrix(T.all_coeffs()).to_DM().to_field()
        return sympy.Matrix(M).to_DM().to_field().unify(right, fmt="dense")

    field, column = system()
    G = TransferFunction(N, D)
    yield "placement, n = 3", {
        "ours": lambda: place_poles(G, polynomial=T, feedback=-1),
        "sympy": lambda: field.lu_solve(column),
    }, {"sympy": solved}  # fmt: skip
    A = sympy.Matrix(3, 3, lambda *_: coefficient())
    B = sympy.Matrix(3, 2, lambda *_: rng.randint(-2, 2))

    def columns():
        return sympy.Matrix.hstack(B, A * B)[:, [0, 2, 1]].to_DM().to_field().to_dense()

    kalman = columns()
    yield "Brunovsky form, 3 x 2", {
        "ours": lambda: brunovsky_form(A, B), "sympy": kalman.inv,
    }, {"sympy": lambda: columns().inv().to_Matrix()}  # fmt: skip
    left, right = A[:2, :], sympy.Matrix(2, 3, lambda *_: rng.randint(-2, 2))
    over = QQ.frac_field(*symbols)[S]  # SymPy has no form of Kronecker's; Smith's is the nearest

    def read_pencil():
        rows = [[over.from_sympy(e) for e in row] for row in (S * right - left).tolist()]
        return DomainMatrix(rows, (2, 3), over)

    pencil = read_pencil()
    yield "Kronecker form, 2 x 3", {
        "ours": lambda: kronecker_form(left, right), "sympy": lambda: smith_normal_decomp(pencil),
    }, {"sympy": lambda: [m.to_Matrix() for m in smith_normal_decomp(read_pencil())]}  # fmt: skip

    def in_s():
        ring = A.to_DM().to_dense()
        return sympy.Poly([ring.domain.to_sympy(c) for c in ring.charpoly()], S)

    square = A.to_DM().to_dense()
    yield "characteristic polynomial", {
        "ours": lambda: characteristic_polynomial(A, S), "sympy": square.charpoly,
    }, {"sympy": in_s}  # fmt: skip


def forgetful(call):
    """The call with nothing remembered of what the one before read."""
    return lambda: (in_symbols.cache_clear(), call())


def symbolic_part(rng):
    """Peers in their own rings, and by hand: the faster of them from expressions to expressions."""
    print(heading("with symbols"))
    for count in (1, 2, 3):
        for name, calls, whole in symbolic_works(count, rng):
            whole = {f"{who} by hand": call for who, call in whole.items()}  # noqa: PLW2901
            seconds = medians(calls | whole | {"ours": forgetful(calls["ours"])})
            seconds["by hand"] = min(seconds.pop(who) for who in whole)
            print(line(name, count, seconds, 2), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--budget", type=float, default=20.0, help="seconds for one peer's run")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--sizes", type=int, nargs="+", default=[10, 20, 50, 100])
    parser.add_argument("--works", nargs="+", help="only those whose name has one of these parts")
    arguments = parser.parse_args()
    compare(arguments.sizes, arguments.budget, random.Random(arguments.seed), arguments.works)
    if arguments.works:
        return
    check_part(100, random.Random(arguments.seed))
    symbolic_part(random.Random(arguments.seed))


if __name__ == "__main__":
    main()
