"""Riccati equations in both time domains, solved in a number field, or in certified balls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Rational, Symbol

from compensator_theory._latex import displayed, latex, words
from compensator_theory._printing import text
from compensator_theory.errors import BudgetError, NoSolutionError, NotControllableError
from compensator_theory.lqg._regulator_data import (
    EnclosedMatrix,
    Weights,
    approximately,
    ball_matrix,
    enclosed_rows,
    read_weights,
)
from compensator_theory.lqg._regulator_spectra import spectrum_of_weights
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exact_matrices import MatrixLike
from compensator_theory.matrices._flint_matrices import from_flint, rational, to_flint
from compensator_theory.matrices._flint_polynomials import from_flint_polynomial
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.polynomials._budget import ask, decimal_digits
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._letters import fresh
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time, require_time, variable_in
from compensator_theory.roots._counts import count_roots
from compensator_theory.roots._enclosures import Enclosure, ball_of_enclosure
from compensator_theory.roots._number_fields import (
    LARGEST_FIELD,
    Arithmetic,
    FieldMatrix,
    Grid,
    NumberField,
    StableFactors,
    by,
    field_matrix,
    grid_of,
    inverse,
    plus,
    stable_factors,
    times,
    transposed,
)
from compensator_theory.roots._spectral_factors import SpectralFactor, factor_spectrum
from compensator_theory.roots._unit_circle_enclosures import working_bits
from compensator_theory.systems._controllability import uncontrollable_polynomial

FlintMatrix: TypeAlias = flint.fmpq_mat | flint.arb_mat
HALF_PLANE = Symbol("s")
NO_GRAPH = (
    "the stable subspace of the Hamiltonian matrix is no graph over the states, so that these "
    "weights have no stabilising solution; make them positive semidefinite"
)
LARGEST_GAIN_FIELD = 64
"""Degree up to which the gain of one input, which is short, is written in a field."""


@dataclass(frozen=True)
class GainFormula(ExactValue):
    r"""The gain of one input by the coefficients of the stable factor, of any degree.

    .. math:: \chi = s^n + c_{n-1}s^{n-1} + \cdots + c_0, \qquad
              K = -k_n - \textstyle\sum_{i<n} c_i k_i, \qquad
              c\,\chi\chi^* = p

    Attributes
    ----------
    coefficients : tuple of sympy.Symbol
        :math:`c_0, \ldots, c_{n-1}`, and in discrete time the constant c.
    values : tuple of Enclosure
        Balls that single out one solution of the relations.
    K : sympy.ImmutableMatrix
        1 x n, linear in the coefficients.
    relations : tuple of sympy.Expr
        Polynomials with rational coefficients that vanish.
    certificate : Certificate
        det(sI - A) - K adj(sI - A) B minus the polynomial, for all values of the coefficients.
    """

    coefficients: tuple[Symbol, ...]
    values: tuple[Enclosure, ...]
    K: ImmutableMatrix
    relations: tuple[Expr, ...]
    certificate: Certificate

    def __str__(self) -> str:
        pairs = zip(self.coefficients, self.values, strict=True)
        where = ", ".join(f"{name} = {value!r}" for name, value in pairs)
        zero = "\n".join(f"{text(relation)} = 0" for relation in self.relations)
        return f"K = {text(self.K)}\n{zero}\n{where}"

    def _repr_latex_(self) -> str:
        return displayed(f"K = {latex(self.K)}", *(f"{latex(r)} = 0" for r in self.relations))


@dataclass(frozen=True)
class RiccatiSolution(ExactValue):
    r"""The stabilising solution of a Riccati equation, and its gain.

    .. math::
        \text{discrete:} \quad P &= A^T P A + Q + (A^T P B + N) K, &
        K &= -(R + B^T P B)^{-1}(B^T P A + N^T) \\
        \text{continuous:} \quad 0 &= A^T P + P A + Q + (P B + N) K, &
        K &= -R^{-1}(B^T P + N^T)

    Attributes
    ----------
    A, B, Q, R, N : sympy.ImmutableMatrix
        The data, n x n, n x m, n x n, m x m, n x m.
    factor : SpectralFactor
        The closed-loop polynomial :math:`\det(sI - A - BK)`; its constant is :math:`\det R`, in
        discrete time :math:`\det(R + B^T P B)`.
    K_in_field : FieldMatrix or None
        m x n, exact; None if its field is larger than the budget.
    K_enclosure, P_enclosure : nested tuples of Enclosure
        m x n and n x n, certified; radii 0 if rational.
    certificate : Certificate or None
        For one input and a controllable pair that K moves the poles to the roots of the stable
        factor, and else that of :attr:`P_in_field`.

    Examples
    --------
    >>> from compensator_theory import solve_riccati
    >>> print(solve_riccati([["3/2"]], [[1]], [[1]], time="discrete"))
    K = [[-3/2]], P = [[1]]
    χ = q
    R + B'PB = 1
    """

    A: ImmutableMatrix
    B: ImmutableMatrix
    Q: ImmutableMatrix
    R: ImmutableMatrix
    N: ImmutableMatrix
    factor: SpectralFactor
    K_in_field: FieldMatrix | None
    K_enclosure: EnclosedMatrix
    P_enclosure: EnclosedMatrix
    certificate: Certificate | None

    @property
    def is_exact(self) -> bool:
        """Whether the gain is known in a number field, in which the solution lies, too."""
        return self.K_in_field is not None

    @property
    def is_rational(self) -> bool:
        """Whether gain and solution are rational."""
        return self.field is not None and self.field.degree == 1

    @property
    def field(self) -> NumberField | None:
        """The field of gain and solution; None beyond the budget."""
        return None if self.K_in_field is None else self.K_in_field.field

    @cached_property
    def P_in_field(self) -> FieldMatrix | None:
        """The solution, n x n, or None beyond the budget; far longer than the gain, so on demand.

        It is handed out with the equation, its symmetry and the sum of the closed-loop poles, which
        the stable ones alone have, evaluated in the field.

        Raises
        ------
        BudgetError
            If it is too long for the budget `digits`; raise it, or use :attr:`P_enclosure`.
        """
        if self.K_in_field is None:
            return None
        weights = (self.A, self.B, self.Q, self.R, self.N)
        return _Work(weights, self.factor.time).solution(self.K_in_field)[0]

    @cached_property
    def K(self) -> ImmutableMatrix | None:
        """The gain in SymPy's numbers; None beyond a field of degree 32, or the budget."""
        return None if self.K_in_field is None else self.K_in_field.written

    @cached_property
    def P(self) -> ImmutableMatrix | None:
        """The solution in SymPy's numbers; None beyond a field of degree 32, or the budget."""
        return None if self.P_in_field is None else self.P_in_field.written

    @property
    def formula(self) -> GainFormula | None:
        """The gain by the coefficients of the factor; None where these do not determine it."""
        return _formula(self)

    @property
    def residual(self) -> EnclosedMatrix:
        """The residual of the equation, recomputed in balls; every entry contains 0."""
        if self.is_rational and self.P is not None:
            weights = (self.A, self.B, self.Q, self.R, self.N)
            exact = _residual([to_flint(m) for m in weights], to_flint(self.P), self.factor.time)
            return tuple(
                tuple(Enclosure(rational(e), Rational(0)) for e in row) for row in exact.tolist()
            )
        finest = max(int(c.centre.q).bit_length() for row in self.P_enclosure for c in row)
        with ball_precision(64 + 2 * finest):
            P = flint.arb_mat([[ball_of_enclosure(c) for c in row] for row in self.P_enclosure])
            balls = [ball_matrix(m) for m in (self.A, self.B, self.Q, self.R, self.N)]
            return enclosed_rows(_residual(balls, P, self.factor.time))

    @property
    def _weight(self) -> str:
        """The name of the constant of the factor."""
        weight = "R + B'PB" if self.factor.time == "discrete" else "R"
        return weight if self.B.cols == 1 else f"det({weight})"

    def __str__(self) -> str:
        K = f"K = {self.K_enclosure if self.K_in_field is None else self.K_in_field}"
        small = self.field is not None and self.field.degree <= 2
        P = f", P = {self.P_in_field}" if small else ""
        where = f"\n{self.field}" if self.field is not None and not small else ""
        chi = str(self.factor).split("\n", maxsplit=1)[0]
        return f"{K}{P}{where}\n{chi}\n{self._weight} = {self.factor.constant!r}"

    def _repr_latex_(self) -> str:
        name = self._weight.replace(chr(39), "^T").replace("det", r"\det")
        weight = f"{name} = {latex(self.factor.constant)}"
        if self.K_in_field is None:
            return displayed(rf"K \approx {approximately(self.K_enclosure)}", weight)
        field = self.K_in_field.field
        place = words(" the greatest real root of ") + latex(field.minimal)
        where = rf"\sigma {place}" if field.degree > 4 else ""
        P = f"P = {latex(self.P_in_field)}" if field.degree <= 2 else ""
        return displayed(f"K = {latex(self.K_in_field)}", P, where, weight)


@refusing
def solve_riccati(
    A: MatrixLike,
    B: MatrixLike,
    Q: MatrixLike | None = None,
    R: MatrixLike | None = None,
    N: MatrixLike | None = None,
    *,
    time: Time | None = None,
    E_1: MatrixLike | None = None,
    E_2: MatrixLike | None = None,
    digits: int = 30,
    variable: str | Symbol | None = None,
) -> RiccatiSolution:
    r"""Solve a regulator's Riccati equation exactly, whatever numbers its solution needs.

    .. math:: J = \sum_k \text{ or } \int \; x^TQx + 2x^TNu + u^TRu, \qquad
              \begin{bmatrix} Q & N \\ N^T & R \end{bmatrix} =
              \begin{bmatrix} E_1^T \\ E_2^T \end{bmatrix}
              \begin{bmatrix} E_1 & E_2 \end{bmatrix} \text{ for } z = E_1 x + E_2 u

    Parameters
    ----------
    A, B : matrix
        n x n and n x m, rational; modes that B does not move must be stable.
    Q, R, N : matrix, optional
        Symmetric n x n and m x m, and n x m, rational. R and N default to zero. R is nonsingular in
        continuous time. The weights need not be definite; then the solution is the stabilising one
        all the same, and perhaps no minimum.
    time : {"continuous", "discrete"}
    E_1, E_2 : matrix, optional
        In place of Q, R and N: l_z x n and l_z x m, rational, the weights as a signal z. E_2
        defaults to zero, which continuous time does not allow.
    digits : int
        Where an answer is not rational, the radius of every ball is at most
        :math:`10^{-\mathrm{digits}}`.
    variable : str or Symbol, optional
        Of the polynomials. Default: s in continuous, q in discrete time.

    Returns
    -------
    RiccatiSolution
        P and K lie in the field of the coefficients of the closed-loop polynomial, which one number
        generates. Up to degree 32 (the budget `field_degree` where that is larger) they are
        computed in it and substituted in the equation; beyond it they are balls.

    Raises
    ------
    NotControllableError
        If a mode that is not stable cannot be moved.
    UnitCircleError
        If the spectrum vanishes on the unit circle: no solution is stabilising.
    NoSolutionError
        If the weights do not determine the input, the spectrum vanishes on the imaginary axis, in
        continuous time R is singular, so that the best gain is infinite (see
        :func:`regulator_locus`), or indefinite weights have no stabilising solution.
    InputError
        If a shape does not fit, an entry is symbolic, a weight is not symmetric, or the variable
        stands for the other time domain.

    Notes
    -----
    ``rcac_numeric.solve_riccati`` answers the same in float64.

    With H the Hamiltonian matrix and :math:`\chi` the Hurwitz factor of its characteristic
    polynomial, the columns of :math:`\chi(-H)` span the stable subspace, and P is read off them. In
    discrete time :math:`s = (z - 1)/(z + 1)` makes the equation a continuous one with solution P/2,
    for singular A and R too. Source: (A.6), (A.7) with the cross term, and their counterpart in
    continuous time. For the estimator give the transposes. "Unique positive-semidefinite solution"
    after (A.12) is true of the stabilising one only: with :math:`R_2 = 0` and :math:`E_1B \ne 0`,
    for instance, :math:`P = E_1^TE_1` is always a positive-semidefinite solution.

    Examples
    --------
    >>> from compensator_theory import solve_riccati
    >>> solution = solve_riccati([[0, 1], ["-1/4", 1]], [[0], [1]], E_1=[["-6/5", 1]],
    ...     time="discrete")
    >>> solution.K, solution.factor.polynomial.as_expr(), solution.factor.constant
    (Matrix([[1/4, -1/6]]), q**2 - 5*q/6, 36/25)
    >>> A, B, Q, R = [[0, 1], [0, 0]], [[0], [1]], [[1, 0], [0, 0]], [[1]]
    >>> solution = solve_riccati(A, B, Q, R, time="continuous")
    >>> print(solution)
    K = [[-1, -sqrt(2)]], P = [[sqrt(2), 1], [1, sqrt(2)]]
    χ = s**2 + 1.4142135623730950488*s + 1.0000000000000000000
    R = 1
    """
    time = require_time(time)
    s = variable_in(time, variable, "this Riccati equation")
    weights = read_weights(A, B, Q, R, N, E_1, E_2)
    working_bits(digits)
    _require_stabilisable(weights, time, s)
    factor = _factor(weights, time, s, digits)
    work = _Work(weights, time)
    if work.factors is None:
        return RiccatiSolution(*weights, factor, None, *work.balls(digits), None)
    field, P = work.factors.field, None
    by_poles = work.gain_of_one_input()
    if by_poles is not None:
        K, certificate = by_poles
    else:
        try:
            P, K, certificate = work.solution()
        except BudgetError:  # the exact solution would be too long to use
            return RiccatiSolution(*weights, factor, None, *work.balls(digits), None)
    if field.degree == 1:
        P = work.solution(K)[0] if P is None else P
        balls = K.enclosures(digits), P.enclosures(digits)
    else:
        balls = work.balls(digits)
    solution = RiccatiSolution(*weights, factor, K, *balls, certificate)
    if P is not None:
        vars(solution)["P_in_field"] = P
    return solution


def _require_stabilisable(weights: Weights, time: Time, s: Symbol) -> None:
    A, B = weights[:2]
    hidden = uncontrollable_polynomial(A, B, variable=s)
    count = count_roots(hidden, time=time)
    if count.boundary or count.unstable:
        raise NotControllableError(
            f"(A, B) has the uncontrollable mode(s) {format_polynomial(hidden)}, which are not all "
            "stable, so that no gain is stabilising; remove them from the realisation first"
        )


def _factor(weights: Weights, time: Time, s: Symbol, digits: int) -> SpectralFactor:
    A, R = weights[0], weights[3]
    if time == "continuous" and R.det() == 0:
        subject = "E_2 = 0 or R = 0" if R.is_zero_matrix else f"R = {R.tolist()} is singular"
        raise NoSolutionError(
            f"{subject}: a direction of u has zero weight, so the optimal gain in continuous time "
            "is infinite; give u a weight, or see regulator_locus for the limits of the poles"
        )
    spectrum = spectrum_of_weights(weights, time, s)
    if spectrum.is_zero:
        raise NoSolutionError(
            "the transfer matrix from u to z has too small a rank (it is zero for a scalar u), so "
            "that no gain is the best: weight u, or drop an input"
        )
    return factor_spectrum(spectrum, A.rows, time, digits)


def half_plane_data(data: Sequence[flint.fmpq_mat], time: Time) -> list[flint.fmpq_mat]:
    r"""Return the data of a continuous equation: with z = (1 + s)/(1 - s) in discrete time.

    With :math:`\xi = x^+ + x` and :math:`\eta = x^+ - x` the identity :math:`x^{+T}Px^+ - x^TPx =
    (\xi^TP\eta + \eta^TP\xi)/2` makes one equation of the other, and P/2 its solution.
    """
    A, B, Q, R, N = data
    if time == "continuous":
        return list(data)
    n, m = B.nrows(), B.ncols()
    unit = _unit(n)
    for k in range(1, 50):  # a feedback that moves an eigenvalue away from -1; P stays
        if (A + unit).det() != 0:
            break
        entries = [(7 * i + 3 * j + k) % 5 - 2 for i in range(m) for j in range(n)]
        K = flint.fmpq_mat(m, n, entries)
        across = data[4] * K
        A, N = data[0] + B * K, data[4] + K.transpose() * R
        Q = data[2] + across + across.transpose() + K.transpose() * R * K
    F = (A + unit).inv()
    G = -(F * B)
    cross = F.transpose() * (Q * G + N)
    weight = R + G.transpose() * Q * G + G.transpose() * N + N.transpose() * G
    return [(A - unit) * F, 2 * F * B, F.transpose() * Q * F, weight, cross]


def hamiltonian(data: Sequence[flint.fmpq_mat]) -> flint.fmpq_mat:
    """Return the Hamiltonian matrix of a continuous equation."""
    A, B, Q, R, N = data
    n = A.nrows()
    row = R.solve(N.transpose())
    a, q = A - B * row, Q - N * row
    s = B * R.solve(B.transpose())
    upper = [[*x, *(-y for y in z)] for x, z in zip(a.tolist(), s.tolist(), strict=True)]
    lower = [[-q[i, j] for j in range(n)] + [-a[j, i] for j in range(n)] for i in range(n)]
    return flint.fmpq_mat([*upper, *lower])


def hamiltonian_spectrum(solution: RiccatiSolution) -> flint.fmpq_poly:
    """The even polynomial whose left roots are the poles of a regulator, in the half plane."""
    weights = (solution.A, solution.B, solution.Q, solution.R, solution.N)
    data = [to_flint(matrix) for matrix in weights]
    return hamiltonian(half_plane_data(data, solution.factor.time)).charpoly()


def _formula(solution: RiccatiSolution) -> GainFormula | None:
    A, B = to_flint(solution.A), to_flint(solution.B)
    n, factor = int(A.nrows()), solution.factor
    if (row := _last_row(A, B)) is None:
        return None
    used_names = {factor.spectrum.gen.name}
    size = fresh(used_names, "c")
    names = tuple(fresh(used_names, f"c{k}") for k in range(n))
    monic = (*names, sympy.Integer(1))
    gain = []  # of each c, and of the leading 1: K is linear in them
    for _ in monic:
        gain.append([-e for e in row.entries()])
        row = row * A
    by_constant = flint.fmpq_mat(gain)
    K = [sympy.Add(*(rational(c) * x for c, x in zip(column, monic, strict=True)))
         for column in by_constant.transpose().tolist()]  # fmt: skip
    p, v, left = A.charpoly().coeffs(), B, []
    for power in range(n - 1, -1, -1):
        moved = (by_constant * v).entries()
        moved[n] -= p[power]
        moved[power] += 1
        left.append(moved)
        v = A * v + B * p[power]
    identity = "det(sI - A) - K adj(sI - A) B = s^n + c_(n-1) s^(n-1) + ... + c_0"
    certificate = certificate_of(identity, [from_flint(flint.fmpq_mat(left))], "formula")
    values = factor.enclosure.coefficients[:0:-1]
    if factor.time == "continuous":
        constant = sympy.sympify(factor.constant.centre)
        relations = [
            sympy.Add(*(
                constant * (-1) ** i * (1 if i == j else 2) * monic[i] * monic[j]
                for i in range(max(0, 2 * k - n), k + 1)
                for j in [2 * k - i]
            ), -factor.spectrum.coeff_monomial(factor.spectrum.gen ** (2 * k)))
            for k in range(n)
        ]  # fmt: skip
        return GainFormula(names, values, ImmutableMatrix([K]), tuple(relations), certificate)
    half = factor.half
    relations = []
    for shift in range(n + 1):
        product = sum(monic[i] * monic[i + shift] for i in range(n + 1 - shift))
        coefficient = factor.spectrum.coeff_monomial(factor.spectrum.gen ** (half + shift))
        relations.append(sympy.expand(size * product - coefficient))
    return GainFormula(
        (*names, size),
        (*values, factor.constant),
        ImmutableMatrix([K]),
        tuple(relations),
        certificate,
    )


def _last_row(A: flint.fmpq_mat, B: flint.fmpq_mat) -> flint.fmpq_mat | None:
    """Return the last row of the inverse controllability matrix; None if there is none."""
    n = A.nrows()
    if B.ncols() != 1:
        return None
    columns = [B]
    for _ in range(n - 1):
        columns.append(A * columns[-1])
    kalman = flint.fmpq_mat([[column[i, 0] for i in range(n)] for column in columns])
    try:
        return kalman.solve(flint.fmpq_mat(n, 1, [0] * (n - 1) + [1])).transpose()
    except ZeroDivisionError:
        return None


def symmetric_system(A: flint.fmpq_mat, B: flint.fmpq_mat) -> flint.fmpq_mat:
    """Return the matrix of P -> (A'P + PA, B'P) on symmetric P, by its entries on and above."""
    n, m = A.nrows(), B.ncols()
    pairs = [(i, j) for i in range(n) for j in range(i, n)]
    index = {pair: k for k, pair in enumerate(pairs)}
    system = flint.fmpq_mat(len(pairs) + n * m, len(pairs))
    for row, (i, j) in enumerate(pairs):
        for k in range(n):
            for (a, b), entry in (((k, j), A[k, i]), ((i, k), A[k, j])):
                place = index[min(a, b), max(a, b)]
                system[row, place] = system[row, place] + entry
    for i in range(m):
        for j in range(n):
            for k in range(n):
                system[len(pairs) + i * n + j, index[min(k, j), max(k, j)]] = B[k, i]
    return system


def pivots(matrix: flint.fmpq_mat) -> list[int]:
    """Return the first columns that are independent."""
    reduced, rank = matrix.rref()
    columns = range(matrix.ncols())
    return [next(j for j in columns if reduced[i, j] != 0) for i in range(int(rank))]


class _Work:
    """Working data of one equation: the Hamiltonian matrix, its stable factor and the results."""

    def __init__(self, weights: Weights, time: Time) -> None:
        self.weights, self.time = weights, time
        self.data = [to_flint(matrix) for matrix in weights]
        self.plane = half_plane_data(self.data, time)
        self.H = hamiltonian(self.plane)
        self.n = int(self.data[0].nrows())

    @cached_property
    def factors(self) -> StableFactors | None:
        most = LARGEST_GAIN_FIELD if self.data[1].ncols() == 1 else LARGEST_FIELD
        return stable_factors(self.H.charpoly(), most=most)

    @cached_property
    def chi(self) -> list[flint.fmpq_poly]:
        assert self.factors is not None
        return self.factors.factors[0]

    @cached_property
    def field(self) -> Arithmetic:
        assert self.factors is not None
        return Arithmetic(self.factors.field)

    def gain_of_one_input(self) -> tuple[FieldMatrix, Certificate] | None:
        """Place the poles at the roots of the stable factor: linear in its coefficients.

        None if there are several inputs, or the factor does not determine the gain.
        """
        A, B = self.data[:2]
        n, work = self.n, self.field
        if (row := _last_row(A, B)) is None:
            return None
        chi = self._factor_in_original_variable()
        total = [flint.fmpq_poly() for _ in range(n)]
        for c in chi:
            total = [x - c * row[0, j] for j, x in enumerate(total)]
            row = row * A
        K = [[x % work.minimal for x in total]]
        # det(sI - A - BK) = det(sI - A) - K adj(sI - A) B, and V are the powers of adj(sI - A) B
        p, v, left = A.charpoly().coeffs(), B, []
        for power in range(n - 1, -1, -1):
            moved = sum((K[0][j] * v[j, 0] for j in range(n)), flint.fmpq_poly())
            left.append((p[power] - moved - chi[power]) % work.minimal)
            v = A * v + B * p[power]
        certificate = certificate_of(
            "det(sI - A) - K adj(sI - A) B = the stable factor",
            [[sympy.Integer(int(any(e != 0 for e in left)))]],
            "gain",
        )
        return field_matrix(work.field, K), certificate

    def _factor_in_original_variable(self) -> list[flint.fmpq_poly]:
        """Return chi(s), or the monic (z + 1)^n chi((z - 1)/(z + 1)), ascending."""
        if self.time == "continuous":
            return self.chi
        n, minimal = self.n, self.field.minimal
        coefficients = [flint.fmpq_poly() for _ in range(n + 1)]
        for k, c in enumerate(self.chi):
            image = flint.fmpq_poly([-1, 1]) ** k * flint.fmpq_poly([1, 1]) ** (n - k)
            for i, factor in enumerate(image.coeffs()):
                coefficients[i] += c * factor
        reciprocal = inverse(coefficients[-1], minimal)
        return [c * reciprocal % minimal for c in coefficients]

    def solution(
        self, gain: FieldMatrix | None = None
    ) -> tuple[FieldMatrix, FieldMatrix, Certificate]:
        """Return P, K and their certificate, or the P that belongs to a gain."""
        work = self.field
        one_input = _last_row(*self.plane[:2]) is not None
        size = max(
            (c.bit_length() for e in self.chi for x in e.coeffs() for c in (x.p, x.q)), default=1
        )
        longest = max(int(c).bit_length() for m in self.H.numer_denom()[:1] for c in m.entries())
        d = work.field.degree
        if d > 1 and not one_input:
            ask(
                "digits",
                decimal_digits(d * self.n * (longest + size // d)),
                "the solution of a Riccati equation",
            )
        try:
            P = self._quadratic() if one_input else self._graph()
            K = _gain(self.data, P, work, self.time) if gain is None else grid_of(gain)
        except ZeroDivisionError as error:
            raise NoSolutionError(NO_GRAPH) from error
        certificate = certificate_of(
            "the Riccati equation, P = P', and the sum of the closed-loop poles",
            _residuals(self.data, P, K, self.chi, work, self.time),
            "Riccati solution",
        )
        return field_matrix(work.field, P), field_matrix(work.field, K), certificate

    def _quadratic(self) -> Grid:
        """Solve for P with the gain known: a linear map with rational inverse.

        In the half plane A'P + PA = K'RK - Q and B'P = -(RK + N'), which is one to one on symmetric
        matrices as (A, B) is controllable.
        """
        A, B, Q, R, N = self.plane
        n, work = self.n, self.field
        row = _last_row(A, B)
        assert row is not None
        K: list[flint.fmpq_poly] = [flint.fmpq_poly() for _ in range(n)]
        for c in self.chi:
            K = [x - c * row[0, j] for j, x in enumerate(K)]
            row = row * A
        system = symmetric_system(A, B)
        pairs = [(i, j) for i in range(n) for j in range(i, n)]
        right = [K[i] * K[j] * R[0, 0] % work.minimal - Q[i, j] for i, j in pairs]
        right += [-(K[j] * R[0, 0] + N[j, 0]) for j in range(n)]
        rows = pivots(system.transpose())
        chosen = flint.fmpq_mat([[system[i, j] for j in range(len(pairs))] for i in rows])
        solution = times(chosen.inv(), [[right[i] % work.minimal] for i in rows])
        index = {pair: k for k, pair in enumerate(pairs)}
        scale = 2 if self.time == "discrete" else 1
        return [
            [solution[index[min(i, j), max(i, j)]][0] * scale for j in range(n)] for i in range(n)
        ]

    def _graph(self) -> Grid:
        """Read P off the stable subspace, the image of chi(-H)."""
        n, work = self.n, self.field
        powers = _powers(-self.H, n)
        bits = 256
        place = work.field.ball(bits)
        with ball_precision(bits):
            near = _combined(powers, [flint.arb_poly(c)(place) for c in self.chi])
            chosen = _independent(near, n)
        zero = flint.fmpq_poly()
        columns: Grid = [
            [sum((c * power[i, j] for c, power in zip(self.chi, powers, strict=True)), zero)
             for i in range(2 * n)]
            for j in chosen
        ]  # fmt: skip
        states, costates = [c[:n] for c in columns], [c[n:] for c in columns]
        scale = self.H.numer_denom()[1] ** n  # the eigenvalues of D H are algebraic integers
        P = transposed(work.solve(states, costates, scale))
        return [[2 * e for e in row] for row in P] if self.time == "discrete" else P

    def balls(self, digits: int) -> tuple[EnclosedMatrix, EnclosedMatrix]:
        """Return enclosures of K and P."""
        n = self.n
        numerators, below = self.H.numer_denom()
        longest = max((abs(c).bit_length() for c in numerators.entries()), default=0)
        bits = int(longest + below.bit_length())  # the k-th power has k times as many
        ask("entries", n**4 * bits // 500, "the powers of a Hamiltonian matrix, term by term,")
        spectrum = from_flint_polynomial(self.H.charpoly(), HALF_PLANE)
        powers = _powers(-self.H, n)
        for precision in (digits * 2**k for k in range(7)):
            working_bits(precision)
            left = factor_spectrum(spectrum, n, "continuous", precision).enclosure.coefficients
            with ball_precision(4 * working_bits(precision)):
                near = _combined(powers, [ball_of_enclosure(c) for c in left[::-1]])
                enclosure = None
                try:
                    chosen = _independent(near, n)
                    states, costates = (
                        flint.arb_mat([[near[i + k, j] for i in range(n)] for j in chosen])
                        for k in (0, n)
                    )
                    P = states.solve(costates).transpose() * (2 if self.time == "discrete" else 1)
                    balls = [ball_matrix(m) for m in self.weights]
                    enclosure = _gain_of(balls, P, self.time), P
                except ZeroDivisionError:  # the balls are too large
                    pass
                if enclosure is not None and all(
                    e.is_finite() for m in enclosure for e in m.entries()
                ):
                    K_rows, P_rows = (enclosed_rows(m) for m in enclosure)
                    radii = [c.radius for rows in (K_rows, P_rows) for row in rows for c in row]
                    if max(radii) <= Rational(1, 10**digits):
                        return K_rows, P_rows
        raise NoSolutionError(NO_GRAPH)  # the subspace is no graph


def _gain(data: Sequence[flint.fmpq_mat], P: Grid, work: Arithmetic, time: Time) -> Grid:
    A, B, _, R, N = data
    row = times(B.transpose(), P)
    weight = work.of(R)
    if time == "discrete":
        weight = plus(weight, by(row, B))
        row = by(row, A)
    row = plus(row, work.of(N.transpose()))
    if time == "continuous":
        return times(-R.inv(), row)
    return work.solve(weight, [[-entry for entry in line] for line in row])


def _residuals(
    data: Sequence[flint.fmpq_mat],
    P: Grid,
    K: Grid,
    chi: Sequence[flint.fmpq_poly],
    work: Arithmetic,
    time: Time,
) -> list[list[sympy.Expr]]:
    """Return the residual of the equation; a single 0 where all entries vanish."""
    A, B, Q, R, N = data
    row = times(B.transpose(), P)
    first = plus(by(row, A) if time == "discrete" else row, work.of(N.transpose()))
    weight = plus(work.of(R), by(row, B)) if time == "discrete" else work.of(R)
    minus = [[-entry for entry in line] for line in P]
    known = (
        [times(A.transpose(), by(P, A)), minus]
        if time == "discrete"
        else [times(A.transpose(), P), by(P, A)]
    )
    left = [
        plus(*known, work.of(Q), work.product(transposed(first), K)),
        plus(work.product(weight, K), first),
        plus(P, transposed(minus)),
        [[_trace_gap(half_plane_data(data, time), P, chi, time)]],
    ]
    reduced = [e % work.minimal for grid in left for line in grid for e in line]
    return [[sympy.Integer(int(any(e != 0 for e in reduced)))]]


def _trace_gap(
    plane: Sequence[flint.fmpq_mat], P: Grid, chi: Sequence[flint.fmpq_poly], time: Time
) -> flint.fmpq_poly:
    """Return the sum of the closed-loop poles minus that of the stable roots, in the half plane.

    The graph of a solution is invariant under the Hamiltonian matrix, so that the closed-loop poles
    are one of each pair of its eigenvalues; the left ones, and no others, have this sum.
    """
    A, B, _, R, N = plane
    n, half = A.nrows(), flint.fmpq(1, 2) if time == "discrete" else flint.fmpq(1)
    fixed, moved = A - B * R.solve(N.transpose()), B * R.solve(B.transpose())
    trace = sum((fixed[i, i] for i in range(n)), flint.fmpq(0))
    through = times(moved, P)
    total = sum((through[i][i] for i in range(n)), flint.fmpq_poly())
    return flint.fmpq_poly([trace]) - total * half + chi[n - 1]


def _gain_of(data: Sequence[FlintMatrix], P: FlintMatrix, time: Time) -> FlintMatrix:
    A, B, _, R, N = data
    row, weight = B.transpose() * P, R
    if time == "discrete":
        weight, row = weight + row * B, row * A
    return weight.solve((row + N.transpose()) * -1)


def _residual(data: Sequence[FlintMatrix], P: FlintMatrix, time: Time) -> FlintMatrix:
    A, B, Q, _, N = data
    K = _gain_of(data, P, time)
    if time == "discrete":
        return A.transpose() * P * A + Q + (A.transpose() * P * B + N) * K - P
    return A.transpose() * P + P * A + Q + (P * B + N) * K


def _powers(matrix: flint.fmpq_mat, n: int) -> list[flint.fmpq_mat]:
    powers = [_unit(matrix.nrows())]
    for _ in range(n):
        powers.append(powers[-1] * matrix)
    return powers


def _unit(n: int) -> flint.fmpq_mat:
    return flint.fmpq_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])


def _combined(powers: Sequence[flint.fmpq_mat], values: Sequence[flint.arb]) -> flint.arb_mat:
    return sum(
        (flint.arb_mat(power) * value for power, value in zip(powers[1:], values[1:], strict=True)),
        flint.arb_mat(powers[0]) * values[0],
    )


def _independent(near: flint.arb_mat, n: int) -> list[int]:
    """Choose n columns whose upper halves seem independent; the solution proves it."""
    entries = [[near[i, j] for j in range(2 * n)] for i in range(n)]
    rows = [[flint.arb(0) if e.contains(0) else e.mid() for e in row] for row in entries]
    sizes = [max(abs(rows[i][j]) for i in range(n)) for j in range(2 * n)]
    rows = [[e / size if size > 0 else e for e, size in zip(row, sizes, strict=True)]
            for row in rows]  # fmt: skip
    chosen: list[int] = []
    for _ in range(n):
        best, i, j = max(
            ((abs(rows[i][j]).mid(), i, j) for i in range(len(rows)) for j in range(2 * n)
             if j not in chosen),
            key=lambda place: place[0],
        )  # fmt: skip
        if not best > 0:
            raise ZeroDivisionError
        chosen.append(j)
        pivot = rows.pop(i)
        rows = [
            [(e - p * (row[j] / pivot[j])).mid() for e, p in zip(row, pivot, strict=True)]
            for row in rows
        ]
    return chosen
