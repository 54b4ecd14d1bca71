"""Answers with symbols held against answers for numbers, on and beside their exceptional sets.

Run with: python benchmarks/substitutions.py [POINTS_OF_EACH] [SEED]

Each construction gets templates with polynomials of a, b, c at four places. Its cases by
`exceptional_cases` are compared, at points of a grid and at points of each case that is solved for
its symbols, with what the construction answers when the numbers are put in first. A point
contradicts if the answers differ there, or one is a refusal that the other is not.
"""

from __future__ import annotations

import itertools
import random
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

import sympy
from sympy import Expr, MatrixBase, Poly

import compensator_theory as exact
from compensator_theory import CompensatorError, exceptional_cases
from compensator_theory.results import JordanForm

s = sympy.Symbol("s")
SYMBOLS = sympy.symbols("a b c")
PARTS = ["a", "b", "c", "a - b", "a*b", "a**2 - b", "b + c", "a**2 - 2*a*b", "0", "1", "-2"]
GRID = [Fraction(k) for k in (-2, -1, 0, 1)] + [Fraction(1, 2), Fraction(3)]

Template = Callable[[str, str, str, str], tuple[tuple[Any, ...], dict[str, Any]]]


def matrices(p: str, q: str, r: str, t: str) -> tuple[Any, Any, Any]:
    """A pair of states and one signal each."""
    return [[p, "1"], [q, r]], [["0"], [t]], [["1", "0"]]


def _plain(*arguments: Any, **options: Any) -> tuple[tuple[Any, ...], dict[str, Any]]:
    return arguments, options


def invariants(*names: str) -> Callable[[Any], tuple[Any, ...]]:
    """What of an answer is unique, so that it must agree."""
    return lambda answer: tuple(getattr(answer, name) for name in names)


CASES: dict[str, tuple[Callable[..., Any], Template, Callable[[Any], Any]]] = {
    "place_poles": (
        exact.place_poles,
        lambda p, q, r, t: _plain(
            f"(s + {p})/(s**2 + {q}*s + {r})", ["-1", "-2", f"-({t})"], feedback=-1
        ),
        lambda x: (x.numerator, x.denominator) if x.is_unique else len(x.homogeneous),
    ),
    "solve_diophantine": (
        exact.solve_diophantine,
        lambda p, q, r, t: _plain(f"s**2 + {p}", f"s + {q}", f"{r}*s + {t}", variable="s"),
        invariants("x", "y", "dx", "dy"),
    ),
    "bezout_identity": (
        exact.bezout_identity,
        lambda p, q, r, t: _plain(f"(s + {p})*(s + {q})", f"(s + {r})*(s + {t})", variable="s"),
        lambda x: x.gcd,
    ),
    "gcd_from_null_space": (
        exact.bezout.gcd_from_null_space,
        lambda p, q, r, t: _plain(f"s**2 + {p}*s + {q}", f"(s + {r})*(s + {t})", variable="s"),
        lambda x: x.gcd,
    ),
    "resultant": (
        exact.resultant,
        lambda p, q, r, t: _plain(f"s**2 + {p}*s + {q}", f"s**2 + {r}*s + {t}", variable="s"),
        lambda x: x,
    ),
    "number_of_common_roots": (
        exact.bezout.number_of_common_roots,
        lambda p, q, r, t: _plain(f"(s + {p})*(s + {q})", f"(s + {r})*(s + {t})", variable="s"),
        lambda x: x,
    ),
    "smith_form": (
        exact.forms.smith_form,
        lambda p, q, r, t: _plain([[f"s + {p}", q], [r, f"s**2 + {t}*s"]], "s"),
        invariants("rank", "invariant_polynomials"),
    ),
    "smith_mcmillan_form": (
        exact.forms.smith_mcmillan_form,
        lambda p, q, r, t: _plain([[f"1/(s + {p})", f"{q}/(s + {r})"], ["0", f"1/(s + {t})"]], "s"),
        invariants("numerators", "denominators", "orders_at_infinity"),
    ),
    "hermite_form": (
        exact.forms.hermite_form,
        lambda p, q, r, t: _plain([[f"s + {p}", q], [f"s + {r}", t]], "s"),
        invariants("form", "rank"),
    ),
    "row_reduced_form": (
        exact.forms.row_reduced_form,
        lambda p, q, r, t: _plain([[f"s**2 + {p}", f"{q}*s"], [f"s + {r}", t]], "s"),
        lambda x: (x.rank, sorted(_row_degrees(x.form))),
    ),
    "popov_form": (
        exact.forms.popov_form,
        lambda p, q, r, t: _plain([[f"s + {p}", q], [f"{r}*s", f"s + {t}"]], "s"),
        invariants("form", "degrees"),
    ),
    "minimal_basis": (
        exact.forms.minimal_basis,
        lambda p, q, r, t: _plain([[f"s + {p}", q, r], ["0", f"s + {t}", "1"]], "s"),
        lambda x: sorted(x.indices),
    ),
    "frobenius_form": (
        exact.forms.frobenius_form,
        lambda p, q, r, t: _plain([[p, "1", "0"], [q, r, "0"], ["0", "0", t]]),
        invariants("form", "invariant_polynomials"),
    ),
    "jordan_form": (
        exact.forms.jordan_form,
        lambda p, q, r, t: _plain([[p, q, "0"], ["0", r, "1"], ["0", "0", t]]),
        lambda x: x,
    ),
    "complex jordan_form": (
        exact.forms.jordan_form,
        lambda p, q, r, t: _plain([[p, q], [r, t]], over="complex"),
        lambda x: x,
    ),
    "kronecker_form": (
        exact.forms.kronecker_form,
        lambda p, q, r, t: _plain([[p, "1", "0"], [q, r, "1"]], [["1", "0", t], ["0", "1", "0"]]),
        invariants("right_indices", "left_indices", "invariant_polynomials", "infinite_orders"),
    ),
    "WeierstrassForm": (
        lambda E, A, B, C: exact.DescriptorSystem(E, A, B, C).weierstrass_form(),
        lambda p, q, r, t: _plain(
            [["1", p], ["0", q]], [["1", r], [t, "1"]], [["0"], ["1"]], [["1", "0"]]
        ),
        lambda x: (x.index, _charpoly(x.J)),
    ),
    "descriptor_realisation": (
        exact.descriptor_realisation,
        lambda p, q, r, t: _plain([[f"{p}*s + {q}/(s + {r})", f"1/(s + {t})"]], "s"),
        lambda x: (x.n, x.transfer_matrix()),
    ),
    "minimal_realisation": (
        exact.minimal_realisation,
        lambda p, q, r, t: _plain([[f"1/(s + {p})", f"{q}/(s + {r})"], ["0", f"1/(s + {t})"]], "s"),
        lambda x: (x.order, x.realisation.transfer_matrix()),
    ),
    "mcmillan_degree": (
        exact.mcmillan_degree,
        lambda p, q, r, t: _plain([[f"1/(s + {p})", f"{q}/(s + {r})"], ["0", f"1/(s + {t})"]], "s"),
        lambda x: x,
    ),
    "kalman_decomposition": (
        exact.kalman_decomposition,
        lambda p, q, r, t: _plain(([[p, "0"], [q, r]], [["1"], [t]], [["1", "1"]]), variable="s"),
        lambda x: x.dimensions,
    ),
    "is_controllable": (
        exact.is_controllable,
        lambda p, q, r, t: _plain([[p, "1"], [q, "0"]], [[r, "1"], ["1", t]]),
        lambda x: x,
    ),
    "uncontrollable_polynomial": (
        exact.uncontrollable_polynomial,
        lambda p, q, r, t: _plain([[p, "1"], ["0", q]], [[r], [t]], variable="s"),
        lambda x: x,
    ),
    "coprime_fractions": (
        exact.coprime_fractions,
        lambda p, q, r, t: _plain([[f"(s + {p})/(s**2 + {q}*s)", f"{r}/(s + {t})"]], "s"),
        lambda x: (x.D_r.determinant().degree(), x.D_l.determinant()),
    ),
    "doubly_coprime_fractions": (
        exact.doubly_coprime_fractions,
        lambda p, q, r, t: _plain(matrices(p, q, r, t), ["-1", "-2"], ["-1", "-3"], variable="s"),
        invariants("K", "F"),
    ),
    "invariant_zeros": (
        exact.invariant_zeros,
        lambda p, q, r, t: _plain(([[p, "1"], [q, r]], [["1"], [t]], [["1", "1"]]), variable="s"),
        invariants("polynomial"),
    ),
    "transmission_zeros": (
        exact.transmission_zeros,
        lambda p, q, r, t: _plain([[f"(s + {p})/(s + 1)", q], [r, f"1/(s + {t})"]], "s"),
        invariants("polynomial"),
    ),
    "regulator_gain": (
        exact.regulator_gain,
        lambda p, q, r, t: _plain([[p, "1"], [q, "0"]], [[r], [t]], ["-1", "-2"]),
        lambda x: x,
    ),
    "brunovsky_form": (
        exact.brunovsky_form,
        lambda p, q, r, t: _plain([[p, "1"], [q, r]], [["1", "0"], [t, "0"]]),
        lambda x: x.indices,
    ),
    "state_feedback_family": (
        exact.state_feedback_family,
        lambda p, q, r, t: _plain([[p, "1"], [q, r]], [["1", "0"], [t, "0"]], ["-1", "-2"]),
        lambda x: x.form.indices,
    ),
    "assign_eigenstructure": (
        exact.assign_eigenstructure,
        lambda p, q, r, t: _plain([["0", "1"], [p, q]], [["0", r], ["1", t]], ["-1", "-2"],
                                  [["1", "-1"], ["1", "-2"]]),
        lambda x: x.K,
    ),
    "solve_sylvester": (
        exact.solve_sylvester,
        lambda p, q, r, t: _plain([[p, "1"], ["0", q]], [[r]], [["1"], [t]]),
        lambda x: len(x.homogeneous) or x.X,
    ),
    "solve_lyapunov": (
        exact.solve_lyapunov,
        lambda p, q, r, t: _plain([[p, "1"], [q, r]], [["1", t], [t, "2"]]),
        lambda x: len(x.homogeneous) or x.X,
    ),
    "solve_stein": (
        exact.solve_stein,
        lambda p, q, r, t: _plain([[p, "1"], ["0", q]], [["1"], [t]], [[r]]),
        lambda x: len(x.homogeneous) or x.X,
    ),
    "solve_regulator_equations": (
        exact.solve_regulator_equations,
        lambda p, q, r, t: _plain(
            ([["0", "1"], [p, q]], [["0"], ["1"]], [["1", r]]), [[t]], [["1"]], variable="s"
        ),
        lambda x: len(x.homogeneous) or (x.Pi, x.Gamma),
    ),
    "interactor": (
        exact.geometry.interactor,
        lambda p, q, r, t: _plain([[f"1/(s + {p})", f"{q}/(s + 1)"], [f"{r}/s", f"{t}/s**2"]], "s"),
        invariants("powers", "matrix"),
    ),
    "decouple": (
        exact.geometry.decouple,
        lambda p, q, r, t: _plain(
            ([[p, "1"], ["0", q]], [["1", r], ["0", "1"]], [["1", "0"], [t, "1"]]), variable="s"
        ),
        invariants("relative_degrees", "matrix"),
    ),
    "controlled_invariant_subspaces": (
        exact.geometry.controlled_invariant_subspaces,
        lambda p, q, r, t: _plain(([[p, "1"], [q, r]], [["1"], [t]], [["1", "0"]]), variable="s"),
        lambda x: (x.V.cols, x.R.cols, x.S.cols, x.zero_polynomial),
    ),
    "laurent_expansion": (
        exact.interpolation.laurent_expansion,
        lambda p, q, r, t: _plain(
            f"(s + {p})/((s + {q})*(s**2 + {r}*s + {t}))", "0", 3, variable="s"
        ),
        invariants("order", "coefficients"),
    ),
    "pade_approximant": (
        exact.interpolation.pade_approximant,
        lambda p, q, r, t: _plain([p, q, r, t], 1, 2),
        lambda x: (x.approximant.numerator, x.approximant.denominator),
    ),
    "partial_realisation": (
        exact.interpolation.partial_realisation,
        lambda p, q, r, t: _plain([p, q, r, t]),
        lambda x: (x.order, x.free_parameters),
    ),
    "zero_order_hold": (
        exact.sampling.zero_order_hold,
        lambda p, q, r, t: _plain(
            ([[p, "1"], ["0", q]], [["1"], [r]], [["1", t]]), "h", variable="s"
        ),
        lambda x: [M.subs(dict(x.exponentials)) for M in x.realisation.matrices],
    ),
}  # fmt: skip


def _row_degrees(matrix: Any) -> list[int]:
    return [max((int(e.degree()) for e in row if not e.is_zero), default=-1) for row in matrix.rows]


def _charpoly(J: MatrixBase) -> Poly:
    return Poly((s * sympy.eye(J.rows) - J).det() if J.rows else 1, s)


def agrees(one: Any, other: Any, at: dict[Expr, Expr]) -> bool:
    """Whether an answer with symbols, the numbers put in, is the answer for the numbers."""
    if isinstance(one, JordanForm):  # a similarity to a Jordan form, whatever its order
        T, J = (M.subs(at) for M in (one.T, one.form))
        theirs = sorted(map(str, (_charpoly(other.form).as_expr().expand(),)))
        ours = sorted(map(str, (sympy.expand(sympy.simplify(_charpoly(J).as_expr())),)))
        return bool(sympy.simplify(T.det()) != 0 and (other.over != one.over or ours == theirs))
    if hasattr(one, "as_matrix"):
        return agrees(one.as_matrix(), other.as_matrix(), at)
    if isinstance(one, Poly):
        return bool(sympy.simplify(one.as_expr().subs(at) - other.as_expr()) == 0)
    if isinstance(one, MatrixBase):
        return one.shape == other.shape and all(
            agrees(x, y, at) for x, y in zip(one, other, strict=True)
        )
    if isinstance(one, Expr):
        return bool(sympy.simplify(one.subs(at) - other) == 0)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(
            agrees(x, y, at) for x, y in zip(one, other, strict=True)
        )
    return bool(one == other)


def points_of(analysis: Any, rng: random.Random) -> Iterator[tuple[Fraction, ...]]:
    """Points of the grid, and of each case that is solved for its symbols."""
    grid = list(itertools.product(GRID, repeat=3))
    rng.shuffle(grid)
    yield from grid[:4]
    for case in analysis.cases:
        solved, values = dict(case.values), rng.choice(grid)
        free = {x: v for x, v in zip(SYMBOLS, values, strict=True) if x not in solved}
        point = [sympy.sympify(solved.get(x, x)).subs(free) for x in SYMBOLS]
        if solved and all(value.is_Rational for value in point):
            yield tuple(Fraction(int(v.p), int(v.q)) for v in point)


def hold(name: str, requested: int, rng: random.Random) -> Counter[str]:
    """Compare a construction at so many points."""
    function, template, key = CASES[name]
    counts: Counter[str] = Counter()
    while sum(counts.values()) < requested:
        parts = [rng.choice(PARTS) for _ in range(4)]
        arguments, options = template(*(f"({part})" for part in parts))
        try:
            cases = exceptional_cases(function, *arguments, cases=60, **options)
        except CompensatorError:  # the template has no answer for any value
            counts["no generic answer"] += 1
            continue
        for point in dict.fromkeys(points_of(cases, rng)):
            at = {
                x: sympy.Rational(v.numerator, v.denominator)
                for x, v in zip(SYMBOLS, point, strict=True)
            }
            numbers = {x.name: v for x, v in at.items()}
            case = cases.at(at)
            if case.status == "open" or case.is_generic:
                counts["open"] += 1
                continue
            filled, also = template(*(f"({sympy.sympify(part, locals=numbers)})" for part in parts))
            kind = "beside" if not case.values and case is cases.generic else "on"
            try:
                expected = function(*filled, **also)
            except CompensatorError as error:
                right = case.status == "refused" and isinstance(error, case.error)
                counts[f"{kind}, refused" if right else "CONTRADICTS"] += 1
                if not right:
                    print(f"  {name} {parts} {point}: {case.status}, but {error}", flush=True)
                continue
            right = case.status == "answered" and agrees(key(case.answer), key(expected), at)
            counts[kind if right else "CONTRADICTS"] += 1
            if not right:
                print(f"  {name} {parts} {point}: {case}\n    but {expected}", flush=True)
    return counts


if __name__ == "__main__":
    points = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    rng = random.Random(int(sys.argv[2]) if len(sys.argv) > 2 else 1)
    total: Counter[str] = Counter()
    for name in CASES:
        begun = time.perf_counter()
        counts = hold(name, points, rng)
        total += counts
        if set(counts) == {"no generic answer"}:
            raise SystemExit(f"{name} refuses its templates: they are not of its kind")
        print(f"{name:32} {time.perf_counter() - begun:6.1f} s  {dict(counts)}", flush=True)
    print(f"{sum(total.values())} points: {dict(total)}")
