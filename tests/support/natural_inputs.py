"""Natural ways to write a polynomial or a system, each with what it means, or that it is refused.

A row holds what somebody types, the canonical object of this package that it stands for, and the
variable that has to be named beside it where it does not show one. The tables are made for s and
for z, so that both halves are held to the same.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from typing import Any

import control
import flint
import numpy as np
import pandas as pd
import scipy.signal
import scipy.sparse
import sympy
from numpy.polynomial import Chebyshev, Polynomial
from sympy.physics.control import Series, StateSpace, TransferFunction, TransferFunctionMatrix

import compensator_theory as exact

REFUSED = None


@dataclass(frozen=True)
class Natural:
    """What is typed, made anew at each use; its canonical object; the variable to be named."""

    name: str
    make: Callable[[], Any]
    canonical: Any
    variable: str | None = None
    beside: Any = None  # what it stands for where another argument shows the variable


class Backwards:
    """A polynomial that can be iterated from its constant on, of a package that nobody knows."""

    def __init__(self, ascending):
        self.ascending = ascending

    def __len__(self):
        return len(self.ascending)

    def __iter__(self):
        return iter(self.ascending)

    def __getitem__(self, power):
        return self.ascending[power]


# Numerator and denominator, zeros and poles: in s of a stable plant, in z of another.
NUMBERS = {
    "s": ([1, 5], [1, 3, 2], [-5], [-1, -2]),
    "z": ([1, 0.25], [1, -0.75, 0.125], [-0.25], [0.5, 0.25]),
}


def rational_in_flint(value):
    return flint.fmpq(*Fraction(value).as_integer_ratio())


def polynomial_inputs(x):
    """The denominator of the plant, in every form, and what lists no coefficients."""
    d = NUMBERS[x][1]
    poly = exact.polynomial(d, x)
    up, symbol = d[::-1], sympy.Symbol(x)
    ring, _ = sympy.ring(x, sympy.QQ)
    first, second = (f"({x} - ({root}))" for root in NUMBERS[x][3])
    listed = {
        "a list": lambda: [*d],
        "a tuple": lambda: (*d,),
        "an array": lambda: np.array(d),
        "an array of float32": lambda: np.array(d, dtype=np.float32),
        "a list of NumPy's numbers": lambda: [np.float64(c) for c in d],
        "a list with a leading zero": lambda: [0, *d],
        "a list of Fractions": lambda: [*map(Fraction, d)],
        "a list of Decimals": lambda: [*map(Decimal, map(str, d))],
        "a list of texts": lambda: [*map(str, d)],
        "a list of SymPy's numbers": lambda: [*map(sympy.Rational, d)],
        "a list of flint's numbers": lambda: [*map(rational_in_flint, d)],
        "a Tuple": lambda: sympy.Tuple(*map(sympy.Rational, d)),
        "a Series of pandas": lambda: pd.Series(d),
        "poly1d": lambda: np.poly1d(d),
        "a Polynomial of NumPy": lambda: Polynomial(up),
        "a Polynomial that ends in zero": lambda: Polynomial([*up, 0.0]),
        "a polynomial of flint": lambda: flint.fmpq_poly([*map(rational_in_flint, up)]),
        "a power series of flint": lambda: flint.fmpq_series([*map(rational_in_flint, up)]),
    }  # fmt: skip
    shown = {
        "a text": lambda: f"{x}**2 + ({d[1]})*{x} + {d[2]}",
        "factors in a text": lambda: f"{first}*{second}",
        "a printed text": lambda: f"{first}·{second}".replace("-", "−"),
        "a printed square": lambda: f"{x}² + ({d[1]})×{x} + {d[2]}".replace("-", "−"),
        "a text with a caret": lambda: f"{x}^2 + ({d[1]})*{x} + {d[2]}",
        "an expression": poly.as_expr,
        "an expression with floats": lambda: sum(float(c) * symbol**k for k, c in enumerate(up)),
        "a Poly": lambda: sympy.Poly(poly.as_expr(), symbol),
        "a named poly1d": lambda: np.poly1d(d, variable=x),
        "a named Polynomial": lambda: Polynomial(up, symbol=x),
        "an element of a ring": lambda: ring.from_expr(poly.as_expr()),
    }
    refused = {
        "Chebyshev's basis": lambda: Chebyshev(up),
        "another domain": lambda: Polynomial(up, domain=[0, 2]),
        "an unknown polynomial": lambda: Backwards(up),
        "a generator": lambda: (c for c in d),
        "a set": lambda: {*d},
        "a dict of powers": lambda: dict(enumerate(up)),
        "a column": lambda: np.array(d).reshape(-1, 1),
        "a masked array": lambda: np.ma.array(d, mask=[0, 1, 0]),
        "a complex coefficient": lambda: np.array([1, 2j, 3]),
        "bytes": lambda: b"123",
    }
    return [
        *(Natural(name, make, poly, x) for name, make in listed.items()),
        *(Natural(name, make, poly) for name, make in shown.items()),
        *(Natural(name, make, REFUSED, x) for name, make in refused.items()),
    ]


def system_inputs(x):
    """The plant in every form, a matrix of several signals, parameters, and what is refused."""
    n, d, zeros, poles = NUMBERS[x]
    symbol, dt = sympy.Symbol(x), 0 if x == "s" else True
    timed = () if x == "s" else (True,)
    G = exact.transfer_function((n, d), x)
    top, bottom = (f"{x} + ({n[1]})", f"{x}**2 + ({d[1]})*{x} + {d[2]}")
    polys = [p.as_expr() for p in (G.numerator, G.denominator)]
    ring, _ = sympy.ring(x, sympy.QQ)
    field, _ = sympy.field(x, sympy.QQ)
    lti = scipy.signal.lti if x == "s" else (lambda *parts: scipy.signal.dlti(*parts, dt=0.5))
    sampled = G if x == "s" else replace(G, sample_time=sympy.Rational(1, 2))
    up = [part[::-1] for part in (n, d)]
    one = exact.transfer_matrix([[G]])
    rows = [
        Natural("text", lambda: f"({top})/({bottom})", G),
        Natural("factors", lambda: f"({top})/(({x} - ({poles[0]}))*({x} - ({poles[1]})))", G),
        Natural("printed", lambda: f"({top})/(({x} − ({poles[0]}))·({x} − ({poles[1]})))", G),
        Natural("caret", lambda: f"({top})/({x}^2 + ({d[1]})*{x} + {d[2]})", G),
        Natural("expression", lambda: polys[0] / polys[1], G),
        Natural("ours", lambda: G, G),
        Natural("our matrix", lambda: exact.transfer_matrix([[G]]), one),
        Natural("pair of texts", lambda: (top, bottom), G),
        Natural("pair of lists", lambda: (n, d), G, x),
        Natural("pair of tuples", lambda: ((*n,), (*d,)), G, x),
        Natural("pair of arrays", lambda: (np.array(n), np.array(d)), G, x),
        Natural("pair with leading zeros", lambda: ([0, *n], d), G, x),
        Natural("text and list", lambda: (top, d), G, x),
        Natural("pair of Polys", lambda: tuple(sympy.Poly(p, symbol) for p in polys), G),
        Natural("pair of poly1d", lambda: tuple(map(np.poly1d, (n, d))), G, x),
        Natural("pair of Polynomials", lambda: tuple(map(Polynomial, up)), G, x),
        Natural("pair of flint's", lambda: tuple(
            flint.fmpq_poly([*map(rational_in_flint, part)])
            for part in up), G, x),
        Natural("pair of elements", lambda: tuple(map(ring.from_expr, polys)), G),
        Natural("element of a field", lambda: field.from_expr(polys[0] / polys[1]), G),
        Natural("pair of Series", lambda: (pd.Series(n), pd.Series(d)), G, x),
        Natural("one entry", lambda: [[f"({top})/({bottom})"]], G),
        Natural("one pair as entry", lambda: [[(n, d)]], G, x),
        Natural("SymPy matrix of one", lambda: sympy.Matrix([[polys[0] / polys[1]]]), one),
        Natural("object array", lambda: np.array([[f"({top})/({bottom})"]], dtype=object), G),
        Natural("three levels", lambda: ([[n]], [[d]]), G, x),
        Natural("three levels over one", lambda: ([[n]], d), G, x),
        Natural("arrays of three levels", lambda: (np.array([[n]]), np.array([[d]])), G, x),
        Natural("zeros and poles", lambda: {"zeros": zeros, "poles": poles}, G, x),
        Natural("python-control", lambda: control.tf(n, d, *timed), G),
        Natural("python-control zpk", lambda: control.zpk(zeros, poles, 1.0, *timed), G),
        Natural("SciPy", lambda: lti(n, d), sampled),
        Natural("SciPy zpk", lambda: lti(zeros, poles, 1.0), sampled),
        Natural("SymPy", lambda: TransferFunction(*polys, symbol), G),
        Natural("SymPy series", lambda: Series(
            TransferFunction(polys[0], 1, symbol), TransferFunction(1, polys[1], symbol)), G),
    ]  # fmt: skip
    A, B, C = [[0, 1], [-d[2], -d[1]]], [[0], [1]], [[n[1], n[0]]]
    states = exact.Realisation(A, B, C, variable=x)
    least = exact.minimal_realisation(G).realisation
    arrays = tuple(map(np.array, (A, B, C)))
    timed_states = replace(states, sample_time=sympy.Rational(1, 2)) if x == "z" else states
    rows += [
        Natural("(A, B, C)", lambda: (A, B, C), states, x),
        Natural("(A, B, C, D)", lambda: (A, B, C, [[0]]), states, x),
        Natural("D = 0", lambda: (A, B, C, 0), states, x),
        Natural("D = 0.0", lambda: (*arrays, 0.0), states, x),
        Natural("D = None", lambda: (A, B, C, None), states, x),
        Natural("flat B and C", lambda: (A, [0, 1], C[0], 0), states, x),
        Natural("flat arrays", lambda: (
            arrays[0], arrays[1].ravel(), arrays[2].ravel()), states, x),
        Natural("flat D", lambda: (*arrays, np.zeros(1)), states, x),
        Natural("[A, B, C]", lambda: [A, B, C], states, x),
        Natural("[A, B, C, D]", lambda: [*arrays, np.zeros((1, 1))], states, x),
        Natural("rows as tuples", lambda: tuple(
            tuple(map(tuple, matrix)) for matrix in (A, B, C)), states, x),
        Natural("SymPy's matrices", lambda: tuple(map(sympy.Matrix, (A, B, C))), states, x),
        Natural("realisation", lambda: states, states),
        Natural("minimal realisation", lambda: exact.minimal_realisation(G), least),
        Natural("python-control ss", lambda: control.ss(A, B, C, 0, dt), states),
        Natural("SciPy ss", lambda: lti(*arrays, np.zeros((1, 1))), timed_states),
    ]  # fmt: skip
    if x == "s":
        rows.append(Natural("SymPy ss", lambda: StateSpace(
            *map(sympy.Matrix, (A, B, C)), sympy.zeros(1)), states))  # fmt: skip
    else:
        stored = exact.sampling.zero_order_hold("2/((s + 1)*(s + 2))", sympy.log(2))
        rows += [
            Natural("sampled plant", lambda: stored, stored.realisation),
            Natural("(A, B, C, D, dt)", lambda: (*arrays, [[0]], 0.5), timed_states),
            Natural("(A, B, C, 0, dt) in z", lambda: [A, B, C, 0, 0.5], timed_states, "z"),
        ]
    num, den = [[[1], [2]], [[3], [4]]], [[d, [1, n[1]]], [[1, n[1]], d]]
    over = [[[1], [2]], [[3], [4]]]
    texts = [[f"1/({bottom})", f"2/({top})"], [f"3/({top})", f"4/({bottom})"]]
    several, common = exact.transfer_matrix(texts), exact.transfer_matrix(
        [[f"{k}/({bottom})" for k in row] for row in ((1, 2), (3, 4))])  # fmt: skip
    square = ([[A[0][0], 1], A[1]], np.eye(2).tolist(), [[1, 0], [2, 1]])
    rows += [
        Natural("rows of texts", lambda: texts, several),
        Natural("rows of pairs", lambda: [
            [([1], d), ([2], [1, n[1]])], [([3], [1, n[1]]), ([4], d)]], several, x),
        Natural("array of texts", lambda: np.array(texts, dtype=object), several),
        Natural("arguments of control.tf", lambda: (num, den), several, x),
        Natural("a list of them", lambda: [num, den], several, x),
        Natural("numerators over one", lambda: (over, d), common, x),
        Natural("python-control matrix", lambda: control.tf(num, den, *timed), several),
        Natural("SymPy's matrix", lambda: TransferFunctionMatrix([
            [TransferFunction(sympy.Integer(k), p, symbol) for k, p in row]
            for row in ([(1, polys[1]), (2, polys[0])], [(3, polys[0]), (4, polys[1])])]), several),
        Natural("matrices of several", lambda: square, exact.Realisation(*square, variable=x), x),
        Natural("constant rows", lambda: [[1, 2], [3, 4]], exact.Realisation(
            sympy.zeros(0), sympy.zeros(0, 2), sympy.zeros(2, 0), [[1, 2], [3, 4]], variable=x
        ).transfer_matrix(), x),
    ]  # fmt: skip
    other = "z" if x == "s" else "q"
    lead = f"({x} + {other})/({x} + p)"
    renamed = exact.transfer_function(f"({x} + c)/({x} + p)", x).subs({"c": other})
    rows += [
        Natural("a parameter called so", lambda: lead, renamed, x),
        Natural("its expression", lambda: sympy.sympify(lead), renamed, x),
        Natural("its lists", lambda: ([1, other], [1, "p"]), renamed, x),
        Natural("its pair of texts", lambda: (f"{x} + {other}", f"{x} + p"), renamed, x),
        Natural("two letters", lambda: lead, REFUSED, None, renamed),
        Natural("π", lambda: f"π/({bottom})", exact.transfer_function(f"pi/({bottom})")),
    ]
    tf2zpk = scipy.signal.tf2zpk(n, d)
    refused = {
        "another letter alone": (lambda: f"1/{other}", x),
        "ss2tf": (lambda: scipy.signal.ss2tf(*arrays, np.zeros((1, 1))), x),
        "tf2zpk": (lambda: tf2zpk, x),
        "(num, den, dt)": (lambda: (n, d, 0.5), x),
        "(zeros, poles, gain, dt)": (lambda: (*tf2zpk, 0.5), x),
        "cont2discrete": (lambda: (np.array([n]), np.array(d), 0.5), x),
        "three levels and dt": (lambda: ([[n]], [[d]], 0.5), x),
        "inner lists": (lambda: [[n, d]], x),
        "Chebyshev": (lambda: (Chebyshev(n), Chebyshev(d)), x),
        "unknown polynomials": (lambda: (Backwards(up[0]), Backwards(up[1])), x),
        "generators": (lambda: ((c for c in n), (c for c in d)), x),
        "sets": (lambda: ({*n}, {*d}), x),
        "a generator of rows": (lambda: ([c] for c in n), x),
        "complex coefficients": (lambda: ([1j], np.array([1, 2 + 1j])), x),
        "a complex system": (lambda: lti([1], [1, 0.5j]), None),
        "a complex text": (lambda: f"1/({x} + j)", None),
        "a list of two lists": (lambda: [n, d], x),
        "two numbers": (lambda: [1, 2], x),
        "rows of two lengths": (lambda: [["1", "2"], ["3"], ["4"]], x),
        "nested lists of two shapes": (lambda: ([[[1], [2]]], [[[1, 2]], [[1, 3]]]), x),
        "matrices that do not fit": (lambda: (A, B, [[1, 2, 3]]), x),
        "a frequency response": (lambda: control.frd([1, 2], [1, 2]), None),
        "a sparse matrix": (lambda: scipy.sparse.eye(2), x),
        "masked": (lambda: (np.ma.array([1, 5], mask=[0, 1]), d), x),
        "a data frame": (lambda: pd.DataFrame(A), x),
        "dead time": (lambda: f"exp(-{x})/({bottom})", None),
        "nothing": (lambda: None, None),
    }
    return [*rows, *(Natural(name, make, REFUSED, v) for name, (make, v) in refused.items())]
