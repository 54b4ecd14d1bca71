"""Observers of a part of the state: of reduced order, of functionals, against unknown inputs."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._terminal import matrix_line
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._flint_matrices import (
    from_flint,
    identity_matrix,
    rational_in_flint,
    zero_matrix,
)
from compensator_theory.matrices._invariant_subspaces import kernel
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    multiplied,
    rank,
    solve,
)
from compensator_theory.placement._observer_gain_families import observer_gain_family
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._from_roots import SpectrumLike, polynomial_or_roots
from compensator_theory.polynomials._poly import monic
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._canonical_forms import RealisationLike, timed_realisation
from compensator_theory.systems._controllability import controllability_matrix
from compensator_theory.systems._realisations import Realisation


@dataclass(frozen=True)
class FunctionalObserver(ExactValue):
    r"""An estimate of L x whose error obeys an autonomous equation, with its certificate.

    .. math:: \dot\zeta = N\zeta + J(y - Du) + Hu, \qquad \hat v = \zeta + E(y - Du), \qquad
              \frac{d}{dt}(\hat v - Lx) = N(\hat v - Lx)

    For z and q read :math:`\zeta(k+1)` for :math:`\dot\zeta`.

    Attributes
    ----------
    plant : Realisation
        (A, B, C, D) with n states, m inputs and p outputs.
    L : sympy.ImmutableMatrix
        r x n: the estimated functions.
    N, J, H, E : sympy.ImmutableMatrix
        r x r, r x p, r x m and r x p.
    fixed : sympy.Poly
        The factor of det(sI - N) that no choice of gains moves; 1 if all of it was placed.
    certificate : Certificate
        With T = L - E C: T A - N T = J C, H = T B, and T G = 0 for unknown inputs G.

    Notes
    -----
    Source: D. G. Luenberger, An introduction to observers, IEEE Trans. Automatic Control 16 (1971);
    M. Darouach, Existence and design of functional observers for linear systems, IEEE Trans.
    Automatic Control 45 (2000).
    """

    plant: Realisation
    L: ImmutableMatrix
    N: ImmutableMatrix
    J: ImmutableMatrix
    H: ImmutableMatrix
    E: ImmutableMatrix
    fixed: Poly
    certificate: Certificate

    @property
    def order(self) -> int:
        """The number of its states, that of the rows of L."""
        return int(self.N.rows)

    @property
    def error_polynomial(self) -> Poly:
        """The polynomial det(sI - N), by which the error of the estimate vanishes."""
        return characteristic_polynomial(self.N, self.plant.variable)

    @property
    def realisation(self) -> Realisation:
        """The system from u and y, in this order, to the estimate of L x."""
        plant, identity = self.plant, identity_matrix(self.order)
        inputs = (self.H - self.J * plant.D).row_join(self.J)
        direct = (-self.E * plant.D).row_join(self.E)
        return Realisation(
            self.N, inputs, identity, direct, plant.variable, sample_time=plant.sample_time
        )

    def compensator(self, K: MatrixLike) -> Realisation:
        r"""Return the compensator of u = K x with the estimate for x, positive feedback.

        Parameters
        ----------
        K : matrix
            m x n, with every row in the span of the rows of L and C.

        Returns
        -------
        Realisation
            From y to u, of the order of the observer. Its certificate proves that the loop has the
            characteristic polynomial :math:`\det(sI - A - BK)\det(sI - N)`.

        Raises
        ------
        InputError
            If the shape is wrong, or K x is no function of L x and y.
        NoSolutionError
            If the loop is not well posed: K feeds the direct term of the plant back onto u.

        Examples
        --------
        The compensator of order n - 1 of a motor, whose position is measured:

        >>> from compensator_theory import reduced_order_observer, regulator_gain
        >>> motor = ([[0, 1], [0, -1]], [[0], [1]], [[1, 0]])
        >>> observer = reduced_order_observer(motor, [-4], variable="s")
        >>> compensator = observer.compensator(regulator_gain(*motor[:2], [-1, -2]))
        >>> print(compensator.transfer_function())
        (-8*s - 8)/(s + 6)
        >>> print(compensator.certificate)
        det(sI - A_cl) = det(sI - A - BK) det(sI - N): holds exactly
        """
        plant, gain = self.plant, exact_matrix(K, "K")
        m, n = int(plant.B.cols), plant.n
        if gain.shape != (m, n):
            raise InputError(f"K is {gain.rows} x {gain.cols}; it must be {m} x {n}")
        of_estimate, of_output = self._split(gain)
        direct = of_estimate * self.E + of_output
        try:
            W = solve(ImmutableMatrix(identity_matrix(m) + direct * plant.D), identity_matrix(m))
        except NoSolutionError as error:
            raise NoSolutionError(
                "the loop is not well posed: I + M D is singular for the direct terms M of the "
                "compensator and D of the plant; choose other poles"
            ) from error
        known = self.H - self.J * plant.D
        compensator = Realisation(
            self.N + known * W * of_estimate, self.J + known * W * direct, W * of_estimate,
            W * direct, plant.variable, feedback=1, sample_time=plant.sample_time,
        )  # fmt: skip
        s = plant.variable
        joined = plant.feedback_with(compensator, feedback=1).characteristic_polynomial
        target = characteristic_polynomial(plant.A + plant.B * gain, s) * self.error_polynomial
        certificate = certificate_of(
            f"det({s}I - A_cl) = det({s}I - A - BK) det({s}I - N)",
            [[(joined - target).as_expr()]],
            "compensator",
        )
        object.__setattr__(compensator, "certificate", certificate)
        return compensator

    def _split(self, K: ImmutableMatrix) -> tuple[ImmutableMatrix, ImmutableMatrix]:
        """K_1 and K_2 with K = K_1 L + K_2 C."""
        basis = self.L.col_join(self.plant.C)
        try:
            rows = _solved_from_the_left(basis, K)
        except NoSolutionError as error:
            raise InputError(
                "K x is no function of L x and y: a row of K is not in the span of the rows of L "
                "and C; make the observer for L = K, or for the whole state"
            ) from error
        return rows[:, : self.order], rows[:, self.order :]

    def _named(self) -> tuple[tuple[str, ImmutableMatrix], ...]:
        return ("N", self.N), ("J", self.J), ("H", self.H), ("E", self.E)

    def __str__(self) -> str:
        s = self.plant.variable
        lines = [matrix_line(name, matrix) for name, matrix in self._named()]
        error = f"the error obeys det({s}I - N) = {format_polynomial(self.error_polynomial)}"
        if self.fixed.degree() > 0:
            error += f", of which {format_polynomial(self.fixed)} cannot be moved"
        return "\n".join([*lines, error])

    def _repr_latex_(self) -> str:
        return displayed(
            *(f"{name} = {latex(matrix)}" for name, matrix in self._named()),
            rf"\det({latex(self.plant.variable)} I - N) = {latex(self.error_polynomial)}",
        )


@refusing
def functional_observer(
    plant: RealisationLike,
    L: MatrixLike,
    poles: SpectrumLike,
    *,
    unknown_inputs: MatrixLike | None = None,
    variable: str | Symbol | None = None,
) -> FunctionalObserver:
    r"""Estimate L x by an observer of as many states as L has rows.

    .. math:: \dot x = Ax + Bu + Gd, \qquad
              \begin{bmatrix} N & K & E \end{bmatrix}
              \begin{bmatrix} L & 0 \\ C & 0 \\ CA & CG \end{bmatrix}
              = \begin{bmatrix} LA & LG \end{bmatrix}, \qquad J = K + NE

    These equations are linear. Their solutions are :math:`N = N_0 - Z N_1` with Z free, so that
    the spectrum of N is placed as that of an observer.

    Parameters
    ----------
    plant : Realisation, matrices, transfer function
        Anything :func:`realisation` reads, without symbols but the variable.
    L : matrix
        r x n, of rank r. The identity estimates the whole state.
    poles : polynomial or list of roots
        Of N; of what can be moved, where some cannot.
    variable : str or Symbol, optional
        As for :func:`realisation`; matrices alone need it.
    unknown_inputs : matrix, optional
        G, n x g: disturbances d enter by it that the estimate is not to feel.

    Returns
    -------
    FunctionalObserver

    Raises
    ------
    NoSolutionError
        If no observer of this order exists; the message names the missing rank.
    InputError
        If L does not have rank r, the shapes or the number of poles do not fit, or there are
        symbols.

    Notes
    -----
    The fixed modes are, for the whole state with unknown inputs, the invariant zeros of
    (A, G, C): they have to be stable. It stands in `fixed` and is not judged. Source: as for
    :class:`FunctionalObserver`.

    Examples
    --------
    Two masses joined by a spring, the second pushed by an unknown force; where it is, and how fast
    the first moves, from the place of the first and the speed of the second:

    >>> from compensator_theory import functional_observer
    >>> A = [[0, 0, 1, 0], [0, 0, 0, 1], [-1, 1, 0, 0], [1, -1, 0, 0]]
    >>> B, C, G = [[0], [0], [1], [0]], [[1, 0, 0, 0], [0, 0, 0, 1]], [[0], [0], [0], [1]]
    >>> L = [[0, 1, 0, 0], [0, 0, 1, 0]]
    >>> print(functional_observer((A, B, C), L, [-1, -2], variable="s", unknown_inputs=G))
    N = [[0, -2], [1, -3]]
    J = [[-6, 1], [-8, 0]]
    H = [[0], [1]]
    E = [[2, 0], [3, 0]]
    the error obeys det(sI - N) = s**2 + 3*s + 2
    """
    whole = timed_realisation(plant, variable, "an observer")
    functional = exact_matrix(L, "L")
    if functional.cols != whole.n:
        raise InputError(
            f"L is {functional.rows} x {functional.cols}; for {whole.n} states it needs "
            f"{whole.n} columns"
        )
    G = zero_matrix(whole.n, 0)
    if unknown_inputs is not None:
        G = exact_matrix(unknown_inputs, "unknown_inputs")
        if G.rows != whole.n:
            raise InputError(
                f"unknown_inputs is {G.rows} x {G.cols}; for {whole.n} states it needs "
                f"{whole.n} rows"
            )
    symbols = set().union(*(m.free_symbols for m in (*whole.matrices, functional, G)))
    if symbols:
        names = ", ".join(sorted(map(str, symbols)))
        raise InputError(
            f"a functional observer needs numbers; give values to {names}, as in matrix.subs(a, 2)"
        )
    if not functional.rows or rank(functional) < functional.rows:
        raise InputError(
            f"L has {functional.rows} rows and rank {rank(functional)}; leave out the rows that "
            "follow from others"
        )
    return _designed(whole, functional, G, polynomial_or_roots(poles, whole.variable))


@refusing
def reduced_order_observer(
    plant: RealisationLike, poles: SpectrumLike, *, variable: str | Symbol | None = None
) -> FunctionalObserver:
    r"""Estimate the states that the outputs do not determine, by an observer of order n - rank C.

    Parameters
    ----------
    plant : Realisation, matrices, transfer function
        Anything :func:`realisation` reads, without symbols but the variable.
    poles : polynomial or list of roots
        Of the observer: n - rank C of them, fewer where modes are unobservable.
    variable : str or Symbol, optional
        As for :func:`realisation`; matrices alone need it.

    Returns
    -------
    FunctionalObserver
        Of the states that complete the rows of C to a basis, so that its
        :meth:`~FunctionalObserver.compensator` exists for every K.

    Raises
    ------
    InputError
        If C has rank n, so that no state is left to estimate, the number of poles is wrong, or
        there are symbols.

    Notes
    -----
    Source: D. G. Luenberger, Observing the state of a linear system, IEEE Trans. Military
    Electronics 8 (1964); as a compensator of order n_c = n - 1, Section 7.2.

    Examples
    --------
    >>> from compensator_theory import reduced_order_observer
    >>> print(reduced_order_observer(([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), [-3], variable="s"))
    N = [[-3]]
    J = [[-9]]
    H = [[1]]
    E = [[3]]
    the error obeys det(sI - N) = s + 3
    """
    whole = timed_realisation(plant, variable, "an observer")
    measured_rows = set(echelon(whole.C).pivots)
    rows = [row for row in range(whole.n) if row not in measured_rows]
    if not rows:
        raise InputError(
            "C has rank n: the outputs determine the whole state; no observer is needed"
        )
    return functional_observer(whole, identity_matrix(whole.n)[rows, :], poles)


def _designed(
    plant: Realisation, L: ImmutableMatrix, G: ImmutableMatrix, polynomial: Poly
) -> FunctionalObserver:
    A, C, r, p = plant.A, plant.C, int(L.rows), int(plant.C.rows)
    _require_short_work(A, C, r)
    zeros = zero_matrix(r + p, G.cols)
    left = ImmutableMatrix(L.col_join(C).row_join(zeros).col_join((C * A).row_join(C * G)))
    right = ImmutableMatrix((L * A).row_join(L * G))
    try:
        particular = _solved_from_the_left(left, right)
    except NoSolutionError as error:
        raise NoSolutionError(_why_not(left, right, plant.C * G, L * G)) from error
    free = kernel(left.T).T  # rows that may be added to a row of the solution
    N, gains, fixed = _placed(particular[:, :r], free[:, :r], polynomial)
    whole = particular - multiplied(gains, free)
    E = whole[:, r + p :]
    J = whole[:, r : r + p] + multiplied(N, E)
    T = L - multiplied(E, C)
    H = multiplied(T, plant.B)
    certificate = certificate_of(
        "T A - N T = J C and T G = 0 for T = L - E C" if G.cols else "T A - N T = J C",
        [multiplied(T, A) - multiplied(N, T) - multiplied(J, C), multiplied(T, G)], "observer",
    )  # fmt: skip
    return FunctionalObserver(plant, L, N, J, H, E, fixed, certificate)


def _require_short_work(A: ImmutableMatrix, C: ImmutableMatrix, order: int) -> None:
    """Check the budget for products of matrices of numbers as long as those of the gain."""
    raw = rational_in_flint(A.col_join(C))
    if raw is None:
        return
    numerators, below = raw.numer_denom()
    bits = max((abs(e).bit_length() for e in numerators.entries()), default=0)
    digits = order**2 * int(bits + below.bit_length() - 1) * 3 // 25  # 2/5 of those of A, decimal
    subject = f"an observer of order {order}, whose gain has some {digits} digits, 500 as an entry,"
    ask("entries", order**3 * digits // 500, subject)


def _placed(
    N_0: ImmutableMatrix, N_1: ImmutableMatrix, polynomial: Poly
) -> tuple[ImmutableMatrix, ImmutableMatrix, Poly]:
    """Return N_0 - Z N_1 with the target spectrum, Z, and the polynomial of the fixed modes."""
    s, r = polynomial.gen, int(N_0.rows)
    krylov_matrix = ImmutableMatrix(controllability_matrix(N_0.T, N_1.T)) if N_1.rows else N_1.T
    basis = echelon(krylov_matrix.T).matrix  # rows span the modes that can be moved
    q = int(basis.rows)
    pivots = set(echelon(basis).pivots)
    rest = [row for row in range(r) if row not in pivots]
    complete = ImmutableMatrix(basis.col_join(identity_matrix(r)[rest, :]))
    inverse = solve(complete, identity_matrix(r))
    moved = multiplied(complete, N_0, inverse)  # in these coordinates, (w; rest), w' = N_w w alone
    fixed = characteristic_polynomial(ImmutableMatrix(moved[q:, q:]), s)
    if polynomial.degree() != q:
        hidden = f"; the root(s) of {format_polynomial(fixed)} cannot be moved" if q < r else ""
        raise InputError(
            f"{format_polynomial(polynomial)} has degree {polynomial.degree()}, but {q} poles "
            f"are to be placed{hidden}"
        )
    if q == 0:
        return N_0, zero_matrix(r, N_1.rows), fixed
    # Of the rows of N_1 as many as are independent; the family needs no more and takes no other.
    rows = echelon(N_1.T).pivots
    rows_of_outputs = multiplied(N_1, inverse)[list(rows), :q]
    F = observer_gain_family(moved[:q, :q], rows_of_outputs, monic(polynomial), variable=s).gain()
    Z, columns = sympy.zeros(r, int(N_1.rows)), multiplied(inverse[:, :q], F)
    for column, row in enumerate(rows):
        Z[:, row] = columns[:, column]
    gains = _in_flint(Z)
    N = N_0 - multiplied(gains, N_1)
    # N has the spectrum of the block that the family has placed, and the fixed modes: a
    # characteristic polynomial of N would be computed from r**2 long numbers.
    placed, block = multiplied(complete, N), moved[:q, :q] - multiplied(F, rows_of_outputs)
    above = placed[:q, :] - multiplied(block, complete[:q, :])
    below = multiplied(placed[q:, :], inverse[:, q:]) - moved[q:, q:]
    certificate_of("S N = [A_p, 0; *, A_f] S", [above, below], "placed spectrum")
    return N, gains, fixed


def _in_flint(matrix: Matrix) -> ImmutableMatrix:
    """Return a matrix in python-flint where its entries are rational."""
    raw = rational_in_flint(matrix)
    return ImmutableMatrix(matrix) if raw is None else from_flint(raw)


def _solved_from_the_left(matrix: ImmutableMatrix, right: ImmutableMatrix) -> ImmutableMatrix:
    """One X with X matrix = right; NoSolutionError if there is none."""
    columns, rows = int(matrix.rows), int(right.rows)
    reduced = echelon(ImmutableMatrix(matrix.T.row_join(right.T)))
    if any(pivot >= columns for pivot in reduced.pivots):
        raise NoSolutionError("the equations contradict each other")
    X = sympy.zeros(rows, columns)
    for row, pivot in enumerate(reduced.pivots):
        X[:, pivot] = reduced.matrix[row, columns:].T
    return _in_flint(X)


def _why_not(
    left: ImmutableMatrix, right: ImmutableMatrix, CG: ImmutableMatrix, LG: ImmutableMatrix
) -> str:
    measured, felt = rank(CG), rank(ImmutableMatrix(CG.col_join(LG)))
    if measured < felt:
        return (
            f"no observer of L x is free of the unknown inputs: rank C G = {measured}, but "
            f"rank [C; L] G = {felt}; measure the states that they enter, or estimate fewer "
            "functions"
        )
    known, both = rank(left), rank(ImmutableMatrix(left.col_join(right)))
    more = " (and free of the unknown inputs)" if CG.cols else ""
    return (
        f"no observer of order {right.rows} estimates L x{more}: its equations have rank {known}, "
        f"with the right side {both}; add rows of L A to L, at most until it is the whole state"
    )
