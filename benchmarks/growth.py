"""How the time of every public function grows, and where a cliff is.

Each function is called with inputs of order n = 2, 5, 10, 20, 50 and 100, then with inputs of order
4 that hold 1 to 4 symbols. Its inputs are those of `tests/support/bad_inputs.GOOD`, which has a
call of every public function, grown by their kind: polynomials of degree n, matrices of n rows,
plants of order n, as many roots as they need, with coefficients of two digits. A new function is
under it as soon as it has a call there; those whose inputs do not grow are named at the end. The
functions of `rcac_numeric` that take a plant are those of `tests/support/numeric_doors.DOORS`,
named with their package, and get a stable plant of order n without symbols. What an
answer computes when it is asked for, its properties and its text, is timed with it, under its
own name.

Every call runs in a child that is ended after so many seconds of processor time, or, where other
work holds the processor, after ten times as many of the clock. A size that is refused or capped is
the last one of its row. The exponent is that of the last step that took more than a millisecond. A
row that took more than 10 s without a refusal by the budget is a cliff; all of them are listed, and
the exit status says whether there are any. With --kept, each measurement is written to a file of
JSON lines as it ends, and what stands in it is not measured again: a run that was ended goes on.

    python benchmarks/growth.py [NAME ...] [--cap 15] [--sizes 2 5 10 20 50 100] [--kept FILE]
"""

import argparse
import json
import math
import multiprocessing
import random
import resource
import signal
import sys
import time
from functools import cached_property
from pathlib import Path

import numpy as np
import sympy

sys.path.insert(0, str(Path(__file__).parents[1]))  # tests/support has a call of every function

import compensator_theory as exact
import rcac_numeric
from compensator_theory._printing import text
from compensator_theory.errors import BudgetError, CompensatorError
from tests.support import bad_inputs, numeric_doors
from tests.support.public import public_objects

TOO_LONG = 10.0
CLOCK = 10  # seconds of the clock for a second of the processor, at most
MOST_CAPPED = 2  # properties of one answer, for each of which it is computed again
ORDER = 4
NAMES = sympy.symbols("a b c d")
NUMERIC = "rcac_numeric."
CONTEXT = multiprocessing.get_context("fork")


class Inputs:
    """Inputs of order n of every kind, with so many symbols in them."""

    def __init__(self, n, symbols=0):
        self.n, self.draw = n, random.Random(f"{n} {symbols}")
        self.names = NAMES[:symbols]

    def _coefficients(self, count):
        numbers = [sympy.Rational(self.draw.randint(1, 99), 10) for _ in range(count)]
        for k, name in enumerate(self.names):
            numbers[k % count] += name
        return numbers

    def poly(self, degree, variable="s"):
        """Return a stable polynomial without symbols, else one with small changes of it."""
        x, product = sympy.Symbol(variable), sympy.Integer(1)
        roots = [sympy.Rational(self.draw.randint(1, 99), 10) for _ in range(degree)]
        if variable != "s":
            roots = [root / 10 for root in roots]
        for root in roots:
            product = sympy.Poly(product, x) * sympy.Poly(x + root, x)
        product = sympy.Poly(product, x).as_expr()
        for k, name in enumerate(self.names):
            product += name * x ** (k % max(1, degree))
        return exact.polynomial(product, variable)

    def _plant(self, variable="s"):
        top = sympy.Poly(self._coefficients(self.n), sympy.Symbol(variable)).as_expr()
        return exact.transfer_function((top, self.poly(self.n, variable)), variable)

    @property
    def _A(self):
        return sympy.Matrix(self.n, self.n, self._entry)

    def _entry(self, i, j):
        number = sympy.Integer(self.draw.randint(-9, 9))
        return number + self.names[i] if i == j and i < len(self.names) else number

    def _matrix(self, rows, columns):
        return [[self.draw.randint(-9, 9) for _ in range(columns)] for _ in range(rows)]

    @property
    def _realisation(self):
        return exact.Realisation(
            self._A, self._matrix(self.n, 1), self._matrix(1, self.n), variable="s"
        )

    @property
    def _transfers(self):
        bottom = self.poly(self.n).as_expr()
        entries = (sympy.Poly(self._coefficients(self.n), sympy.Symbol("s")) for _ in range(4))
        a, b, c, d = (entry.as_expr() / bottom for entry in entries)
        return exact.transfer_matrix([[a, b], [c, d]], "s")

    def _polynomials(self, size):
        return [[self.poly(2).as_expr() + i * j for j in range(size)] for i in range(size)]

    def _standard(self, variable):
        n, unit = self.n, [[int(i == j) for j in range(self.n)] for i in range(self.n)]
        system = (self._A, self._matrix(n, 1), self._matrix(1, n))
        return exact.lqg_problem(system, unit, [[1]], unit, [[1]], variable=variable)

    def _roots(self, count):
        return [-1 - sympy.Rational(k, 3) for k in range(count)]

    def grown(self, value):
        """Return an argument of a kind that grows at this size, another as it is."""
        for kind, maker in self._kinds():
            if value is kind or (isinstance(kind, str) and value == kind):
                return maker()
        return value

    def _kinds(self):
        n = self.n
        return [
            (bad_inputs._P, lambda: self.poly(n)), (bad_inputs._Q, lambda: self.poly(n - 1)),
            (bad_inputs._G, self._plant), (bad_inputs._POLY, lambda: self.poly(n)),
            (bad_inputs._A, lambda: self._A), (bad_inputs._B, lambda: self._matrix(n, 1)),
            (bad_inputs._C, lambda: self._matrix(1, n)), (bad_inputs._R, lambda: self._realisation),
            (bad_inputs._MATRIX, lambda: self._transfers),
            (bad_inputs._STANDARD, lambda: self._standard("z")),
            (bad_inputs._CONTINUOUS, lambda: self._standard("s")),
            (bad_inputs._SERVO, lambda: exact.servo_problem(self._plant("q"))),
        ]  # fmt: skip

    def arguments(self, name):
        """Return the call of a function at this size, and whether its inputs have grown."""
        if name.startswith(NUMERIC):
            return self._numeric(name.removeprefix(NUMERIC)), {}, True
        built = self._own(name)
        positional, named = bad_inputs.GOOD[name]
        if built is not None:
            return built, named, True
        grown = [self.grown(value) for value in positional]
        return grown, named, any(a is not b for a, b in zip(grown, positional, strict=True))

    def _numeric(self, name):
        """Return lightly damped modes and delays, in float64, as a plant or as matrices."""
        n, draw = self.n, self.draw
        if name == "solve_riccati":
            A = [[draw.gauss(0, 1) / n**0.5 for _ in range(n)] for _ in range(n)]
            return [A, self._matrix(n, 2)]
        q = sympy.Symbol("q")
        below = sympy.Poly(q ** (n // 4), q)
        while (missing := n - int(below.degree())) > 0:
            radius = sympy.Rational(draw.randint(30, 95), 100)
            turn = 2 * radius * sympy.Rational(draw.randint(-9, 9), 10)
            below *= sympy.Poly(q**2 - turn * q + radius**2 if missing > 1 else q - radius, q)
        above = sympy.Poly(self._coefficients(max(1, n // 2)), q)
        return [exact.transfer_function((above, below), "q")]

    def _own(self, name):
        """Return arguments that belong together, or that are of no kind above."""
        n = self.n
        stable, small = sympy.Symbol("s"), max(1, n // 2)
        unit = [[int(i == j) for j in range(n)] for i in range(n)]
        makers = {
            "solve_diophantine": lambda: [self.poly(n), self.poly(n - 1), self.poly(2 * n - 1)],
            "regulator_gain": lambda: [self._A, self._matrix(n, 1), self._roots(n)],
            "observer_gain": lambda: [self._A, self._matrix(1, n), self._roots(n)],
            "state_feedback_family": lambda: [self._A, self._matrix(n, 2), self._roots(n)],
            "observer_gain_family": lambda: [self._A, self._matrix(2, n), self._roots(n)],
            "observer_based_compensator": lambda: [
                self._realisation, self._roots(n), self._roots(n)
            ],
            "place_poles": lambda: [self._plant(), self._roots(2 * n - 1)],
            "functional_observer": lambda: [
                self._realisation, self._matrix(1, n), self._roots(n - 1)
            ],
            "reduced_order_observer": lambda: [self._realisation, self._roots(n - 1)],
            "doubly_coprime_fractions": lambda: [self._realisation, self._roots(n), self._roots(n)],
            "stabilising_compensators": lambda: [self._realisation, self._roots(n), self._roots(n)],
            "solve_lyapunov": lambda: [self._A, unit],
            "solve_stein": lambda: [self._A / 100, unit, self._A.T / 100],
            "solve_sylvester": lambda: [self._A, (self._A - 50 * sympy.eye(n)).tolist(), unit],
            "solve_riccati": lambda: [self._A, self._matrix(n, 1), unit, [[1]]],
            "riccati_formula": lambda: [self._A, self._matrix(n, 1), unit, [[1]]],
            "regulator_spectrum": lambda: [self._A, self._matrix(n, 1), unit, [[1]]],
            "regulator_locus": lambda: [self.poly(n - 1), self.poly(n)],
            "jordan_form": lambda: [self._A.tolist()],
            "kronecker_form": lambda: [self._A, self._matrix(n, n)],
            "stabilising_gains": lambda: [self._plant()],
            "stability_margins": lambda: [self._plant()],
            "root_locus": lambda: [self._plant()],
            "first_order_hold": lambda: [self._plant(), "1/2"],
            "tustin": lambda: [self._plant(), "1/2"],
            "stability_conditions": lambda: [self.poly(n)],
            "stability_intervals": lambda: [
                self.poly(n).as_expr() + sympy.Symbol("a") * self.poly(n - 1).as_expr(), "a"
            ],
            "stability_region": lambda: [
                self.poly(n).as_expr() + sympy.Symbol("k_p") * stable + sympy.Symbol("k_i"),
                "k_p", "k_i",
            ],
            "stability_delays": lambda: [[self.poly(n), self.poly(n - 1)]],
            "decide_strong_stabilisability": lambda: [self._plant()],
            "decide_interval_stability": lambda: [
                [(c, c + 1) for c in self.poly(n).all_coeffs()]
            ],
            "count_observer_forms": lambda: [self.poly(n), small],
            "split_at_unit_circle": lambda: [
                exact.polynomial(self.poly(n, "z").as_expr() * (sympy.Symbol("z") + 2))
            ],
            "enclose_split_at_unit_circle": lambda: [
                exact.polynomial(self.poly(n, "z").as_expr() + 5)
            ],
            "spectral_factor": lambda: [self.poly(n, "z"), "z", 3],
            "polynomial_matrix": lambda: [self._polynomials(n)],
            "hermite_form": lambda: [self._polynomials(n)],
            "row_reduced_form": lambda: [self._polynomials(n)],
            "smith_form": lambda: [self._polynomials(n)],
            "popov_form": lambda: [self._polynomials(n)],
            "minimal_basis": lambda: [[self._polynomials(n)[0], self._polynomials(n)[1]]],
            "hankel_matrix": lambda: [self._transfers, n, n],
            "markov_parameters": lambda: [self._plant(), 2 * n],
            "laurent_expansion": lambda: [self._plant(), -1, 2 * n],
            "partial_realisation": lambda: [self._coefficients(2 * n)],
            "pade_approximant": lambda: [self._coefficients(2 * n + 1), n, n],
            "nevanlinna_pick": lambda: [list(range(1, n + 1)), [[1, -k] for k in range(n)], 999],
            "polynomial_from_roots": lambda: [self._roots(n), "s"],
            "read_roots": lambda: [self._roots(n)],
            "sampling_zero_polynomial": lambda: [n],
            "zero_order_hold": lambda: [self._realisation, "h"],
            "matched": lambda: [self._realisation, "h"],
            "gramians": lambda: [self._stable_realisation(), "s"],
            "lqg_problem": lambda: [
                (self._A, self._matrix(n, 1), self._matrix(1, n)), unit, [[1]], unit, [[1]]
            ],
            "decide_simultaneous_stabilisability": lambda: [self._plant(), self._plant()],
        }  # fmt: skip
        return makers[name]() if name in makers else None

    def _stable_realisation(self):
        return exact.realisation(self._plant())


def answers_of(result, name):
    """Yield the names of what an answer computes when it is asked for, and how."""
    # Python writes no integer of more than 4300 digits; our types do, and tuples of them do not.
    written = text if isinstance(result, tuple | list | dict) else str
    yield f"str({name})", lambda: written(result)
    packages = ("compensator_theory", "rcac_numeric")
    ours = [base for base in type(result).__mro__ if base.__module__.startswith(packages)]
    attributes = {
        attribute: held for base in reversed(ours) for attribute, held in vars(base).items()
    }
    for attribute, value in sorted(attributes.items()):
        if attribute[0] != "_" and isinstance(value, property | cached_property):
            yield f"{name}.{attribute}", lambda attribute=attribute: getattr(result, attribute)


def work(pipe, name, inputs, cap, skipped):
    """Call a function, then ask its answer, and say how long each took."""
    function = FUNCTIONS[name]

    def timed(label, call):
        used = math.ceil(time.process_time() + cap)
        resource.setrlimit(resource.RLIMIT_CPU, (used, resource.RLIM_INFINITY))
        pipe.send((label, None, ""))
        begin, answer, note = time.thread_time(), None, ""
        try:
            answer = call()
        except BudgetError:
            note = "budget"
        except CompensatorError as refusal:
            note = type(refusal).__name__
        pipe.send((label, time.thread_time() - begin, note))
        return answer, note

    try:
        positional, named, _ = inputs.arguments(name)
    except CompensatorError as refusal:  # of inputs that cannot be made, with symbols for instance
        pipe.send((name, 0.0, type(refusal).__name__))
        pipe.send(("", None, ""))
        return
    result, note = timed(name, lambda: function(*positional, **named))
    for label, call in () if note else answers_of(result, name):
        if label not in skipped:
            timed(label, call)
    pipe.send(("", None, ""))


def measure(name, inputs, cap, already):
    """Return {label: (seconds, note)} of one call in a child; what is skipped has no row."""
    rows_done, skipped = {}, set(already)
    while True:
        parent, there = CONTEXT.Pipe(False)
        child = CONTEXT.Process(target=work, args=(there, name, inputs, cap, skipped), daemon=True)
        child.start()
        there.close()
        pending = name
        try:
            while pending:
                if not parent.poll(CLOCK * cap):  # the processor is another's
                    child.kill()
                    child.join()
                    break
                label, seconds, note = parent.recv()
                if seconds is not None:
                    rows_done[label] = seconds, note
                else:
                    pending = label
        except EOFError:  # ended by the cap, or by an error of its own
            child.join()
        if pending:
            note = {-signal.SIGXCPU: "capped", -signal.SIGKILL: "waited"}.get(child.exitcode)
            rows_done[pending] = (float(cap) if note == "capped" else 0.0, note or "failed")
            skipped.add(pending)
        child.join()
        if not pending or pending == name or len(skipped) > len(already) + MOST_CAPPED:
            return rows_done


class Kept:
    """The measurements of a file of JSON lines, to which new ones are written as they end."""

    def __init__(self, path):
        self.path, self.found = path, {}
        if path is not None and path.exists():
            for line in path.read_text().splitlines():
                name, kind, size, value = json.loads(line)
                self.found[name, kind, size] = value

    def measured(self, name, kind, size, call):
        """Return what stands in the file, else what the call measures."""
        if (name, kind, size) not in self.found:
            self.found[name, kind, size] = value = call()
            if self.path is not None:
                with self.path.open("a") as file:
                    file.write(json.dumps([name, kind, size, value]) + "\n")
        return self.found[name, kind, size]


def rows(name, kind, points, cap, records):
    """Return {label: [(size, seconds, note)]}; a row ends where it is refused or capped."""
    rows_done, ended = {}, set()
    for size, inputs in points:
        measured = records.measured(name, kind, size, lambda i=inputs: measure(name, i, cap, ended))
        for label, (seconds, note) in measured.items():
            if label not in ended:
                rows_done.setdefault(label, []).append((size, seconds, note))
            if note:
                ended.add(label)
        if name in ended:
            break
    return rows_done


def exponent(row):
    """Return the growth of the last step, None where it takes no time."""
    timed = [(n, t) for n, t, note in row if t > 1e-3 and note != "capped"]
    if len(timed) < 2:
        return None
    (n, t), (m, u) = timed[-2:]
    return math.log(u / t) / math.log(m / n)


def written(row):
    """Write one row."""
    power = exponent(row)
    cells = [f"{n}: {note + ' ' if note else ''}{t:.3g}" for n, t, note in row]
    return "  ".join(cells) + ("" if power is None else f"  exponent {power:.1f}")


def is_cliff(row):
    """Tell whether the last call took long and the budget had not refused it, or failed."""
    _, seconds, note = row[-1]
    return seconds > TOO_LONG or note in ("capped", "waited", "failed")


def grows(name):
    """Tell whether the inputs of a function grow."""
    return Inputs(3).arguments(name)[2]


FUNCTIONS = {
    name: one
    for name, one in public_objects("compensator_theory").items()
    if name in bad_inputs.GOOD and callable(one)
}
FUNCTIONS |= {
    NUMERIC + name: lambda G, door=door: door(G, None)
    for name, door in numeric_doors.DOORS.items()
    if name != "load_run"  # reads a file
}
FUNCTIONS[NUMERIC + "solve_riccati"] = lambda A, B: rcac_numeric.solve_riccati(
    A, B, np.eye(len(A)), np.eye(2), time="discrete"
)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("names", nargs="*", default=sorted(FUNCTIONS), metavar="NAME")
    parser.add_argument("--sizes", nargs="+", type=int, default=[2, 5, 10, 20, 50, 100])
    parser.add_argument("--cap", type=float, default=15.0)
    parser.add_argument("--kept", type=Path, help="a file of JSON lines")
    options = parser.parse_args()
    cliffs, fixed, cached = [], [], Kept(options.kept)
    for name in options.names:
        if not grows(name):
            fixed.append(name)
            continue
        numbers = [(n, Inputs(n)) for n in options.sizes]
        symbols = [(m, Inputs(ORDER, m)) for m in range(1, len(NAMES) + 1)]
        kinds = [("n", numbers), ("symbols", [] if name.startswith(NUMERIC) else symbols)]
        for kind, points in kinds:
            for label, row in rows(name, kind, points, options.cap, cached).items():
                line = f"{label:40} {kind:8} {written(row)}"
                if label == name or max(t for _, t, _ in row) > 0.1:
                    print(line, flush=True)
                if is_cliff(row):
                    cliffs.append(line)
    print(f"\n{len(cliffs)} of more than {TOO_LONG:g} s, or failed:", *cliffs, sep="\n")
    print("\ninputs that do not grow:", ", ".join(fixed))
    sys.exit(bool(cliffs))


if __name__ == "__main__":
    main()
