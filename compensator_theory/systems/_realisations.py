"""State-space realisations with exact data, their hidden modes and their transfer functions."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import reduce
from numbers import Number
from operator import matmul
from typing import TYPE_CHECKING, TypeAlias

from sympy import Expr, ImmutableMatrix, Poly, Rational, Symbol

from compensator_theory._latex import displayed, table
from compensator_theory._terminal import matrix_line
from compensator_theory.errors import ImproperError, InputError, NoSolutionError
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._flint_matrices import identity_matrix, symbols_in, zero_matrix
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    in_lowest_terms,
    solve,
)
from compensator_theory.polynomials._budget import ask, is_integer, repr_of
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._reading import is_one_of
from compensator_theory.polynomials._variables import as_symbol, require_one_symbol_a_name
from compensator_theory.roots._certified import Root
from compensator_theory.roots._closed_forms import RootFormula, roots_of
from compensator_theory.systems._controllability import is_controllable, uncontrollable_polynomial
from compensator_theory.systems._sample_times import (
    System,
    control_state_space,
    period_in,
    shared_sample_time,
    time_base,
)
from compensator_theory.systems._state_space import transfer_matrix_of_realisation
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix

if TYPE_CHECKING:
    import control

# Connections of state-space systems: parallel, series, feedback; all states stay.

Matrices: TypeAlias = tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]
"""(A, B, C, D)."""


def in_parallel(first: Matrices, second: Matrices) -> Matrices:
    """Return the matrices of y = y_1 + y_2."""
    (A, B, C, D), (A_2, B_2, C_2, D_2) = first, second
    above, below = (
        A.row_join(zero_matrix(A.rows, A_2.cols)),
        zero_matrix(A_2.rows, A.cols).row_join(A_2),
    )
    return above.col_join(below), B.col_join(B_2), C.row_join(C_2), D + D_2


def in_series(last: Matrices, before: Matrices) -> Matrices:
    """Return the matrices of u to the one before, and its output to the last."""
    (A, B, C, D), (A_2, B_2, C_2, D_2) = last, before
    above = A.row_join(B * C_2)
    below = zero_matrix(A_2.rows, A.rows).row_join(A_2)
    return above.col_join(below), (B * D_2).col_join(B_2), C.row_join(D * C_2), D * D_2


def in_feedback(plant: Matrices, other: Matrices, feedback: int) -> Matrices:
    """Return the matrices from v to y of the plant under u = v + f K y."""
    (A_1, B_1, C_1, D_1), (A_2, B_2, C_2, D_2) = plant, other
    n, n_2 = int(A_1.rows), int(A_2.rows)
    p, m = int(D_1.rows), int(D_1.cols)
    K_C, K_D = feedback * C_2, feedback * D_2
    try:  # y = E (C x + D K_C x_k + D v)
        E = solve(identity_matrix(p) - D_1 * K_D, identity_matrix(p))
    except NoSolutionError as error:
        raise ImproperError(
            "the loop is not well posed: det(I - f D D_k) = 0 for the direct terms; use a "
            "strictly proper one"
        ) from error
    C = E * C_1.row_join(D_1 * K_C)
    D = E * D_1
    u = (K_D * C) + zero_matrix(m, n).row_join(K_C)
    u_v = identity_matrix(m) + K_D * D
    below = zero_matrix(n_2, n).row_join(A_2) + B_2 * C
    above = A_1.row_join(zero_matrix(n, n_2)) + B_1 * u
    A, B = above.col_join(below), (B_1 * u_v).col_join(B_2 * D)
    a, b, c, d = map(in_lowest_terms, (A, B, C, D))
    return a, b, c, d


@dataclass(frozen=True, init=False)
class Realisation(System):
    r"""A plant or a compensator in a given basis, hidden modes included.

    .. math:: \dot x = A x + B u, \qquad y = C x + D u

    Parameters
    ----------
    A, B, C, D : matrix
        n x n, n x m, p x n, p x m, read by :func:`exact_number`; D = None or 0 means zero.
    variable : str or Symbol
        Variable of the transfer functions; default ``s``. For ``z`` and ``q`` read
        :math:`x(k+1)` for :math:`\dot x`.
    certificate : Certificate, optional
        Where it was made from a transfer function: that the two are the same.
    feedback : {+1, -1}, optional
        Of a compensator: the sign of the loop that it was designed for.
    sample_time : number, optional
        As of :class:`TransferFunction`.

    Raises
    ------
    InputError
        If the shapes do not fit; the message names the matrix.

    Notes
    -----
    Source: (7.1)-(7.4).

    Examples
    --------
    >>> from compensator_theory import Realisation
    >>> plant = Realisation([[-1, 4], [0, -3]], [[0], [1]], [[1, 0]])  # Example 7.1
    >>> plant.is_minimal, str(plant.transfer_function())
    (True, '(4)/(s**2 + 4*s + 3)')
    >>> (plant @ plant - plant).n, plant.dual().A[1, 0]
    (6, 4)
    """

    A: ImmutableMatrix
    B: ImmutableMatrix
    C: ImmutableMatrix
    D: ImmutableMatrix
    variable: Symbol
    certificate: Certificate | None = field(default=None, compare=False)
    feedback: int | None = field(default=None, compare=False)
    sample_time: Rational | None = None

    def __init__(
        self,
        A: MatrixLike,
        B: MatrixLike,
        C: MatrixLike,
        D: MatrixLike | None = None,
        variable: str | Symbol = "s",
        certificate: Certificate | None = None,
        feedback: int | None = None,
        sample_time: NumberLike | None = None,
    ) -> None:
        symbol = as_symbol(variable)
        object.__setattr__(self, "variable", symbol)
        object.__setattr__(self, "certificate", certificate)
        object.__setattr__(self, "feedback", feedback)
        object.__setattr__(self, "sample_time", period_in(symbol, sample_time))
        a, b, c = exact_matrix(A, "A"), exact_matrix(B, "B"), exact_matrix(C, "C")
        # MATLAB's habit: the number 0 for the zero matrix.
        is_zero = type(D) is int and D == 0
        d = zero_matrix(c.rows, b.cols) if D is None or is_zero else exact_matrix(D, "D")
        n, m, p = a.rows, b.cols, c.rows
        symbols = {symbol}
        for name, matrix, needed in zip(
            "ABCD", (a, b, c, d), ((n, n), (n, m), (p, n), (p, m)), strict=True
        ):
            if matrix.shape != needed:
                raise InputError(
                    f"{name} is {matrix.rows} x {matrix.cols} but must be {needed[0]} x "
                    f"{needed[1]}, as the other matrices show"
                )
            if symbol in (occurring := symbols_in(matrix)):
                raise InputError(
                    f"{name} contains {symbol}, the variable of the transfer function; name "
                    "another one with variable="
                )
            symbols |= occurring
            object.__setattr__(self, name, matrix)
        require_one_symbol_a_name(symbols)
        if not (m and p):
            raise InputError(f"a realisation needs inputs and outputs; it has {m} and {p}")

    @property
    def n(self) -> int:
        """Number of states."""
        return int(self.A.rows)

    @property
    def matrices(self) -> Matrices:
        """The four of them, (A, B, C, D)."""
        return self.A, self.B, self.C, self.D

    @property
    def is_siso(self) -> bool:
        """Whether there are one input and one output."""
        return bool(self.D.shape == (1, 1))

    @property
    def is_strictly_proper(self) -> bool | None:
        """Whether D = 0; None if that depends on the value of a symbol."""
        known: bool | None = self.D.is_zero_matrix
        return known

    @property
    def is_controllable(self) -> bool | None:
        """Whether every mode feels the input; None if that depends on the value of a symbol."""
        return is_controllable(self.A, self.B)

    @property
    def is_observable(self) -> bool | None:
        """Whether every mode shows in the output; None if that depends on a symbol."""
        return is_controllable(self.A.T, self.C.T)

    @property
    def is_minimal(self) -> bool | None:
        """Whether it is controllable and observable; None if that depends on a symbol."""
        verdicts = (self.is_controllable, self.is_observable)
        return False if False in verdicts else None if None in verdicts else True

    @property
    def characteristic_polynomial(self) -> Poly:
        """The polynomial det(sI - A), unreduced."""
        return characteristic_polynomial(self.A, self.variable)

    def poles(self) -> tuple[Root | RootFormula, ...]:
        """Return the eigenvalues of A: certified, or with symbols in closed form.

        Raises
        ------
        NoSolutionError
            If, with symbols, an irreducible factor of det(sI - A) has degree three or more.

        Examples
        --------
        >>> from compensator_theory import realisation
        >>> spring = realisation(([[0, 1], ["-k/m", 0]], [[0], [1]], [[1, 0]]), "s")
        >>> print(*spring.poles(), sep="; ")
        -I*sqrt(k)/sqrt(m); I*sqrt(k)/sqrt(m)
        """
        return roots_of(self.characteristic_polynomial)

    @property
    def uncontrollable_modes(self) -> Poly:
        """Monic polynomial of the uncontrollable modes; 1 if there are none."""
        return uncontrollable_polynomial(self.A, self.B, variable=self.variable)

    @property
    def unobservable_modes(self) -> Poly:
        """Monic polynomial of the unobservable modes; 1 if there are none."""
        return uncontrollable_polynomial(self.A.T, self.C.T, variable=self.variable)

    def transfer_matrix(self) -> TransferMatrix:
        """Return C (sI - A)^-1 B + D over the unreduced det(sI - A)."""
        return transfer_matrix_of_realisation(*self.matrices, self.variable, self.sample_time)

    def transfer_function(self) -> TransferFunction:
        """Return the only entry of the transfer matrix; InputError if there are several."""
        scalar = self.transfer_matrix().scalar()
        return scalar if self.feedback is None else replace(scalar, feedback=self.feedback)

    def in_basis(self, T: MatrixLike) -> Realisation:
        """Return the realisation for the state T^-1 x, that is (T^-1 A T, T^-1 B, C T, D)."""
        basis = exact_matrix(T, "T")
        if basis.shape != (self.n, self.n):
            raise InputError(
                f"T is {basis.rows} x {basis.cols}, but a basis for {self.n} states is "
                f"{self.n} x {self.n}"
            )
        both = solve(basis, (self.A * basis).row_join(self.B))
        A, B, C = both[:, : self.n], both[:, self.n :], self.C * basis
        return replace(self._like(A, B, C, self.D), feedback=self.feedback)

    def dual(self) -> Realisation:
        """Return (A', C', B', D'), whose transfer matrix is the transpose."""
        return self._like(self.A.T, self.C.T, self.B.T, self.D.T)

    def feedback_with(self, other: Realisation, *, feedback: int) -> Realisation:
        r"""Return the loop from v to y of u = v + f K y, :math:`(I - f G K)^{-1} G`, no state lost.

        Raises
        ------
        ImproperError
            If det(I - f D D_k) = 0: the loop is not well posed.
        InputError
            If the signals or the variables do not fit, or f is neither +1 nor -1.
        """
        if not is_one_of(feedback, (1, -1)):
            raise InputError(f"feedback = {repr_of(feedback)} must be +1 (u = v + K y) or -1")
        self._require(other, other.D.shape == self.D.T.shape, "feedback around it")
        joined = in_feedback(self.matrices, other.matrices, feedback)
        return self._like(*joined, other)

    def __add__(self, other: Realisation) -> Realisation:
        """Return both in parallel, y = y_1 + y_2, all states kept."""
        if not isinstance(other, Realisation):
            return NotImplemented
        self._require(other, other.D.shape == self.D.shape, "in parallel with it")
        return self._like(*in_parallel(self.matrices, other.matrices), other)

    def __neg__(self) -> Realisation:
        return self._like(self.A, self.B, -self.C, -self.D)

    def __sub__(self, other: Realisation) -> Realisation:
        return self + -other if isinstance(other, Realisation) else NotImplemented

    def __matmul__(self, other: Realisation) -> Realisation:
        """Return both in series, u to the other and its output to this one, all states kept."""
        if not isinstance(other, Realisation):
            return NotImplemented
        self._require(other, other.C.rows == self.B.cols, "in series before it")
        return self._like(*in_series(self.matrices, other.matrices), other)

    def __mul__(self, other: Realisation | NumberLike) -> Realisation:
        """Both in series, or every output times a number."""
        if isinstance(other, Realisation):
            return self @ other
        k = _factor(other)
        return NotImplemented if k is None else self._like(self.A, self.B, self.C * k, self.D * k)

    def __rmul__(self, other: NumberLike) -> Realisation:
        return self * other

    def __truediv__(self, other: Realisation | NumberLike) -> Realisation:
        if isinstance(other, Realisation):
            return self @ other.inverse()
        k = _factor(other)
        if k == 0:
            raise InputError("a realisation is not divided by zero")
        return NotImplemented if k is None else self * (1 / k)

    def __pow__(self, exponent: int) -> Realisation:
        """Return a power in series, of the inverse for a negative exponent; the identity for 0."""
        if not is_integer(exponent):
            raise TypeError(f"{exponent!r} is no exponent of a realisation; an int is")
        self._require(self, self.D.rows == self.D.cols, "in series with it")
        ask("entries", (self.n * abs(exponent)) ** 2, "the power of a realisation")
        result, one = self.inverse() if exponent < 0 else self, identity_matrix(self.D.rows)
        if not exponent:
            none = zero_matrix(0, 0)
            return self._like(none, zero_matrix(0, one.rows), zero_matrix(one.rows, 0), one)
        return reduce(matmul, [result] * abs(exponent))

    def inverse(self) -> Realisation:
        r"""Return :math:`(A - BD^{-1}C,\ BD^{-1},\ -D^{-1}C,\ D^{-1})`, from y to u.

        Raises
        ------
        ImproperError
            If D has no inverse, for an improper system then takes y to u.
        """
        A, B, C, D = self.matrices
        try:
            if D.rows != D.cols:
                raise NoSolutionError("not square")
            inverse = solve(D, identity_matrix(D.rows))
        except NoSolutionError as error:
            raise ImproperError(
                f"D = {D.tolist()} has no inverse, so that the inverse system is improper; "
                "transfer_matrix().inverse() is a transfer matrix"
            ) from error
        return self._like(A - B * inverse * C, B * inverse, -inverse * C, inverse)

    def _like(
        self, A: MatrixLike, B: MatrixLike, C: MatrixLike, D: MatrixLike,
        other: Realisation | None = None,
    ) -> Realisation:  # fmt: skip
        """Return a realisation with other matrices and the same variable and sample time."""
        period = shared_sample_time(self, other)
        return Realisation(A, B, C, D, self.variable, sample_time=period)

    def _require(self, other: Realisation, fits: bool, place: str) -> None:
        if other.variable != self.variable:
            raise InputError(
                f"one realisation is in {self.variable} and the other in {other.variable}; both "
                "need one variable"
            )
        if not fits:
            raise InputError(
                f"a realisation of {other.D.shape} signals does not fit {place}, which has "
                f"{self.D.shape} (outputs, inputs)"
            )

    def with_sign(self, feedback: int) -> Realisation:
        """Return the compensator of u = G_c y for one of u = f G_c y: (A, B, f C, f D)."""
        return self._like(self.A, self.B, feedback * self.C, feedback * self.D)

    def to_control(self, dt: float | bool | None = None) -> control.StateSpace:
        """Return the python-control object; every entry is rounded once to float64.

        Parameters
        ----------
        dt : float or bool, optional
            As for :meth:`TransferFunction.to_control`.

        Raises
        ------
        InputError
            If an entry is symbolic or overflows, or `dt` is needed and missing.
        """
        time = time_base(self.variable, self.sample_time, dt)
        return control_state_space(*self.matrices, time)

    def __str__(self) -> str:
        names = ("A", "B", "C") if self.is_strictly_proper else ("A", "B", "C", "D")
        return "\n".join(matrix_line(name, getattr(self, name)) for name in names)

    def _repr_latex_(self) -> str:
        return displayed(table([[self.A, self.B], [self.C, self.D]]))


def _factor(obj: object) -> Expr | None:
    """Read a number or an expression; None for objects with arithmetic operators of their class."""
    return exact_number(obj) if isinstance(obj, str | Expr | Number) else None
