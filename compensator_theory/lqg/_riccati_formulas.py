"""Riccati equations with symbols: closed forms in square roots, orders 1 and 2, one input each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, TypeAlias

import sympy
from sympy import Dummy, Expr, ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory._printing import text
from compensator_theory._terminal import matrix_line
from compensator_theory.errors import InputError, NoSolutionError, NotControllableError
from compensator_theory.lqg._regulator_data import Weights, read_weights
from compensator_theory.lqg._riccati import RiccatiSolution, solve_riccati
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exact_matrices import MatrixLike
from compensator_theory.matrices._exceptional_factors import denominators_of, exceptional_factors
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    solve,
)
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._substitution import (
    Substitutions,
    names_in,
    read_values,
    substituted,
)
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time, require_time

IDENTITY = "the Riccati equation and its gain, modulo the squares of the roots"


@dataclass(frozen=True)
class RiccatiFormula(ExactValue):
    r"""The stabilising solution of a Riccati equation as a function of symbols.

    .. math:: \chi = s + \sqrt{e_0} \quad\text{or}\quad
              \chi = s^2 + \sqrt{e_1 + 2\sqrt{e_0}}\;s + \sqrt{e_0}

    in the half plane, for the spectrum :math:`e_0 - s^2`, or :math:`s^4 - e_1s^2 + e_0`.

    Attributes
    ----------
    A, B, Q, R, N : sympy.ImmutableMatrix
        The data.
    time : {"continuous", "discrete"}
    K, P : sympy.ImmutableMatrix
        m x n and n x n, in square roots.
    conditions : tuple of sympy.Expr
        The radicands. All positive: the stable subspace exists, and no pole is on the
        boundary of stability.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the formula holds where none of them is zero.
    certificate : Certificate
        The equation with the solution put in.
    """

    _REST: ClassVar[str] = ".conditions and .exceptional list them"
    A: ImmutableMatrix
    B: ImmutableMatrix
    Q: ImmutableMatrix
    R: ImmutableMatrix
    N: ImmutableMatrix
    time: Time
    K: ImmutableMatrix
    P: ImmutableMatrix
    conditions: tuple[Expr, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def at(self, values: Substitutions, value: NumberLike | None = None) -> RiccatiSolution:
        """Return the solution for rational values of all symbols, on the exceptional set too.

        They are given as to SymPy's `subs`.

        Raises
        ------
        InputError
            If a symbol has no value.
        """
        weights = (self.A, self.B, self.Q, self.R, self.N)
        known, numbers = names_in(weights), read_values(values, value)
        if missing := sorted(known - {symbol.name for symbol in numbers}):
            raise InputError(f"give a value for {', '.join(missing)}, too")
        A, B, Q, R, N = substituted(weights, numbers)
        return solve_riccati(A, B, Q=Q, R=R, N=N, time=self.time)

    def __str__(self) -> str:
        lines = [matrix_line("K", self.K), matrix_line("P", self.P)]
        lines += [f"{text(condition)} > 0" for condition in self.conditions]
        return "\n".join([*lines, *(f"{text(factor)} != 0" for factor in self.exceptional)])

    def _repr_latex_(self) -> str:
        return displayed(
            f"K = {latex(self.K)}",
            f"P = {latex(self.P)}",
            *(f"{latex(condition)} > 0" for condition in self.conditions),
            unless(self.exceptional),
        )


@refusing
def riccati_formula(
    A: MatrixLike,
    B: MatrixLike,
    Q: MatrixLike | None = None,
    R: MatrixLike | None = None,
    N: MatrixLike | None = None,
    *,
    time: Time | None = None,
    E_1: MatrixLike | None = None,
    E_2: MatrixLike | None = None,
) -> RiccatiFormula:
    r"""Solve a Riccati equation with symbols, of order 1 or 2 and with one input, in square roots.

    Several inputs are solved one by one where each acts on one or two states of its own.

    Parameters
    ----------
    A, B, Q, R, N, time, E_1, E_2
        As for :func:`solve_riccati`; every entry may have symbols, which stand for real numbers.
        n = 1 or 2 and one input, or several equations of that kind that neither A and B nor the
        weights couple, in any order of the states and inputs.

    Raises
    ------
    NotControllableError
        If (A, B) is not controllable for any values.
    NoSolutionError
        If the weight of u in continuous time, or its spectrum at z = -1, is zero for all values.
    InputError
        If more than 2 states (from 3 on the coefficients are no square roots; substitute numbers
        and see :attr:`RiccatiSolution.formula`) or several inputs are coupled, or a shape does not
        fit.

    Notes
    -----
    For order 1 in discrete time :math:`P = ((a^2 - 1)r + b^2q + \sqrt{(b^2q + r(a - 1)^2)(b^2q +
    r(a + 1)^2)})/(2b^2)`.

    Examples
    --------
    >>> from compensator_theory import riccati_formula
    >>> formula = riccati_formula([["a"]], [[1]], Q=[["q"]], R=[[1]], time="continuous")
    >>> formula.P, formula.conditions
    (Matrix([[a + sqrt(a**2 + q)]]), (a**2 + q,))
    >>> formula = riccati_formula([[0, 1], [0, 0]], [[0], [1]], Q=[["q", 0], [0, 0]], R=[["r"]],
    ...     time="continuous")
    >>> formula.K, formula.exceptional
    (Matrix([[-sqrt(q/r), -sqrt(2)*(q/r)**(1/4)]]), (r,))
    >>> formula = riccati_formula([["a", 0], [0, "b"]], [[1, 0], [0, 1]], Q=[[1, 0], [0, "q"]],
    ...     R=[[1, 0], [0, 1]], time="continuous")
    >>> formula.P[1, 1], formula.conditions
    (b + sqrt(b**2 + q), (a**2 + 1, b**2 + q))
    """
    time = require_time(time)
    weights = read_weights(A, B, Q, R, N, E_1, E_2, symbols=True)
    blocks = _blocks(weights)
    for states, inputs in blocks:
        if len(states) > 2 or len(inputs) > 1:
            raise InputError(
                f"the equation couples {len(states)} state(s) and {len(inputs)} input(s); closed "
                "forms in square roots are for orders 1 and 2 and one input, and for several such "
                "equations that do not couple. Substitute numbers for the symbols, and see "
                "solve_riccati and the formula of its result"
            )
        if not inputs:
            raise NotControllableError(
                f"no input acts on the state {states[0] + 1}, so that (A, B) is controllable for "
                "no values of the symbols"
            )
    if len(blocks) == 1:
        return _of_one_input(weights, time)
    solutions = [_of_one_input(_part(weights, *block), time) for block in blocks if block[0]]
    for states, inputs in blocks:
        if not states and sympy.cancel(weights[3][inputs[0], inputs[0]]) == 0:
            raise NoSolutionError(
                f"the weight of the input {inputs[0] + 1}, which moves no state, is zero for all "
                "values, so that no gain is the best"
            )
    n, m = weights[1].shape
    K, P = sympy.zeros(m, n), sympy.zeros(n, n)
    for (states, inputs), solution in zip([b for b in blocks if b[0]], solutions, strict=True):
        for i, row in enumerate(states):
            K[inputs[0], row] = solution.K[0, i]
            for j, column in enumerate(states):
                P[row, column] = solution.P[i, j]
    idle = [weights[3][inputs[0], inputs[0]] for states, inputs in blocks if not states]
    factors = [factor for solution in solutions for factor in solution.exceptional]
    exceptional = exceptional_factors([*factors, *(r for r in idle if r.free_symbols)])
    conditions = tuple(dict.fromkeys(c for solution in solutions for c in solution.conditions))
    left = [solution.certificate.residual for solution in solutions]
    certificate = certificate_of(IDENTITY, left, "Riccati formula")
    return RiccatiFormula(
        *weights, time, ImmutableMatrix(K), ImmutableMatrix(P), conditions, exceptional, certificate
    )


Block: TypeAlias = tuple[list[int], list[int]]
"""States and inputs that the data couple with each other, and with no others."""


def _blocks(weights: Weights) -> list[Block]:
    """Return the connected parts of states and inputs, by their first state or input."""
    A, B, Q, R, N = weights
    n, m = B.shape
    coupled: list[set[int]] = [{k} for k in range(n + m)]  # the inputs after the states
    pairs = [(i, j) for i in range(n) for j in range(n) if A[i, j] != 0 or Q[i, j] != 0]
    pairs += [(i, n + j) for i in range(n) for j in range(m) if B[i, j] != 0 or N[i, j] != 0]
    pairs += [(n + i, n + j) for i in range(m) for j in range(m) if R[i, j] != 0]
    for one, other in pairs:
        if coupled[one] is not coupled[other]:
            joined = coupled[one] | coupled[other]
            for k in joined:
                coupled[k] = joined
    parts = [sorted(part) for part in {id(part): part for part in coupled}.values()]
    return [([k for k in part if k < n], [k - n for k in part if k >= n]) for part in parts]


def _part(weights: Weights, states: list[int], inputs: list[int]) -> Weights:
    """Return the data of one block."""
    A, B, Q, R, N = (ImmutableMatrix(part) for part in weights)
    return (
        A.extract(states, states), B.extract(states, inputs), Q.extract(states, states),
        R.extract(inputs, inputs), N.extract(states, inputs),
    )  # fmt: skip


def _of_one_input(weights: Weights, time: Time) -> RiccatiFormula:
    """Solve the equation of one input and of order 1 or 2."""
    a, b = weights[:2]
    n = int(a.rows)
    if determinant(_kalman(a, b)) == 0:
        raise NotControllableError("(A, B) is controllable for no values of the symbols")
    plane = _half_plane(weights, time)
    if plane[3][0] == 0:
        subject = "the weight of u" if time == "continuous" else "the spectrum at z = -1"
        raise NoSolutionError(f"{subject} is zero for all values, so that no gain is the best")
    roots, squares, chi = _stable_factor(plane)
    gain = _placed(plane[0], plane[1], chi)
    P = _symmetric_solution(plane, gain)
    K = gain
    if time == "discrete":
        P = 2 * P
        closed = (gain * (a + identity_matrix(n))) / (1 - (gain * b)[0])
        K = closed.applyfunc(lambda e: _reduced(e, roots, squares))
    P = P.applyfunc(lambda e: _reduced(e, roots, squares))
    K = K.applyfunc(lambda e: _reduced(e, roots, squares))
    left = [_remainder(e, roots, squares) for m in _equations(weights, K, P, time) for e in m]
    certificate = certificate_of(IDENTITY, [left], "Riccati formula")
    written: dict[Expr, Expr] = {}
    for root, square in zip(roots, squares, strict=True):
        written[root] = sympy.sqrt(sympy.factor(square.subs(written)))
    divisors = [determinant(_kalman(*plane[:2])), plane[3][0], *denominators_of(plane)]
    if time == "discrete":
        divisors += [determinant(a + identity_matrix(n)), determinant(_kalman(a, b))]
    divisors += denominators_of((K, P))
    conditions = tuple(_rebuilt(sympy.factor(square.subs(written))) for square in squares)
    K, P = (ImmutableMatrix(m.subs(written).applyfunc(_rebuilt)) for m in (K, P))
    exceptional = exceptional_factors(d for d in divisors if d.free_symbols)
    return RiccatiFormula(*weights, time, K, P, conditions, exceptional, certificate)


def _kalman(A: Matrix, B: Matrix) -> Matrix:
    return B if A.rows == 1 else B.row_join(A * B)


def _half_plane(weights: Weights, time: Time) -> tuple[Matrix, ...]:
    """Return the data of the continuous equation with the solution P, or P/2."""
    A, B, Q, R, N = weights
    if time == "continuous":
        return weights
    unit = identity_matrix(A.rows)
    if determinant(A + unit) == 0:
        raise InputError(
            "A has the eigenvalue -1 for all values of the symbols; move it by a feedback first"
        )
    F = solve(A + unit, unit)
    G = -F * B
    cross = F.T * (Q * G + N)
    weight = R + G.T * Q * G + G.T * N + N.T * G
    data = (A - unit) * F, 2 * F * B, F.T * Q * F, weight, cross
    return tuple(ImmutableMatrix(m.applyfunc(sympy.cancel)) for m in data)


def _stable_factor(plane: tuple[Matrix, ...]) -> tuple[list[Symbol], list[Expr], list[Expr]]:
    """Return names for the roots, their squares, and the ascending factor in these names."""
    A, B, Q, R, N = plane
    r = R[0]
    drift, weight = A - B * N.T / r, Q - N * N.T / r
    upper = drift.row_join(-B * B.T / r)
    H = ImmutableMatrix(upper.col_join((-weight).row_join(-drift.T)).applyfunc(sympy.cancel))
    w = Dummy()  # without a name, which a symbol of the data may have
    even = [sympy.cancel(c) for c in characteristic_polynomial(H, w).all_coeffs()[::2]]
    if A.rows == 1:
        names, squares, root = _root(-even[1], "w_0")
        return names, squares, [root, sympy.Integer(1)]
    names, squares, last = _root(even[2], "w_0")
    if sympy.cancel(1 + even[1] + even[2]) == 0:
        # -1 is a root, in discrete time 0: the other choice of a sign would be no graph over x
        return names, squares, [last, 1 + last, sympy.Integer(1)]
    more, their_squares, middle = _root(-even[1] + 2 * last, "w_1")
    return names + more, squares + their_squares, [last, middle, sympy.Integer(1)]


def _root(square: Expr, name: str) -> tuple[list[Symbol], list[Expr], Expr]:
    """Return a square root: its name and its square, or no name for a positive rational number."""
    root = sympy.sqrt(square)
    if root.is_Rational and root.is_positive:
        return [], [], root
    root = Dummy(name, positive=True)
    return [root], [square], root


def _placed(A: Matrix, B: Matrix, chi: list[Expr]) -> Matrix:
    n = A.rows
    row = solve(_kalman(A, B).T, Matrix([0] * (n - 1) + [1])).T
    total = sympy.zeros(1, n)
    for c in chi:
        total -= c * row
        row = (row * A).applyfunc(sympy.cancel)
    return total


def _symmetric_solution(plane: tuple[Matrix, ...], K: Matrix) -> Matrix:
    """Solve A'P + PA = K'RK - Q and B'P = -(RK + N') for the entries of P."""
    A, B, Q, R, N = plane
    n = A.rows
    names = [Dummy() for _ in range(3)]
    P = Matrix([[names[0]]]) if n == 1 else Matrix([[names[0], names[1]], [names[1], names[2]]])
    unknown = list(names[: n * (n + 1) // 2])
    first = A.T * P + P * A + Q - K.T * R * K
    rows = [*(B.T * P + R * K + N.T), *first]
    chosen: list[Expr] = []
    for row in rows:
        system = sympy.linear_eq_to_matrix([*chosen, row], unknown)[0]
        if system.applyfunc(sympy.cancel).rank(simplify=True) > len(chosen):
            chosen.append(row)
        if len(chosen) == len(unknown):
            break
    system, right = sympy.linear_eq_to_matrix(chosen, unknown)
    inverse = solve(ImmutableMatrix(system.applyfunc(sympy.cancel)), identity_matrix(len(unknown)))
    solution = dict(zip(unknown, inverse * right, strict=True))
    return Matrix(P.subs(solution))


def _equations(weights: Weights, K: Matrix, P: Matrix, time: Time) -> list[Matrix]:
    A, B, Q, R, N = weights
    if time == "continuous":
        return [A.T * P + P * A + Q + (P * B + N) * K, R * K + B.T * P + N.T]
    return [
        A.T * P * A + Q - P + (A.T * P * B + N) * K,
        (R + B.T * P * B) * K + B.T * P * A + N.T,
    ]


def _rebuilt(value: Expr) -> Expr:
    """Rebuild an expression by SymPy: factors that it does not combine would not pickle."""
    return value.func(*map(_rebuilt, value.args)) if value.args else value


def _remainder(value: Expr, roots: list[Symbol], squares: list[Expr]) -> Expr:
    """Return the numerator with squares of the roots replaced; zero where the value is."""
    top = sympy.fraction(sympy.cancel(value))[0]
    for root, square in zip(reversed(roots), reversed(squares), strict=True):
        poly = Poly(top, root)
        even = sum(c * square ** (k // 2) * root ** (k % 2) for (k,), c in poly.terms())
        top = sympy.fraction(sympy.cancel(even))[0]
    return sympy.expand(top)


def _reduced(value: Expr, roots: list[Symbol], squares: list[Expr]) -> Expr:
    """Write a value without roots below the line, and each root at most once above it."""
    top, bottom = sympy.fraction(sympy.cancel(value))
    for root, square in zip(reversed(roots), reversed(squares), strict=True):
        parts = []
        for side in (top, bottom):
            poly = Poly(side, root)
            even = sum(c * square ** (k // 2) for (k,), c in poly.terms() if k % 2 == 0)
            odd = sum(c * square ** (k // 2) for (k,), c in poly.terms() if k % 2)
            parts.append((sympy.sympify(even), sympy.sympify(odd)))
        (a, b), (c, d) = parts
        if d == 0:
            value = sympy.cancel(a / c) + sympy.cancel(b / c) * root
        else:
            norm = c**2 - square * d**2
            value = (
                sympy.cancel((a * c - square * b * d) / norm)
                + sympy.cancel((b * c - a * d) / norm) * root
            )
        top, bottom = sympy.fraction(sympy.cancel(value))
    constant = sympy.cancel(top / bottom)
    return sympy.collect(sympy.expand(constant), roots, sympy.factor)
