"""Descriptor systems: differential equations together with algebraic ones, and their modes."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory._terminal import matrix_line
from compensator_theory.errors import ImproperError, InputError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._exceptional_factors import (
    denominators_of,
    exceptional_factors,
)
from compensator_theory.matrices._flint_matrices import identity_matrix, symbols_in, zero_matrix
from compensator_theory.matrices._invariant_subspaces import joined
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    in_lowest_terms,
    multiplied,
    rank,
    solve,
)
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._poly import canonical, from_coefficients
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import require_one_symbol_a_name
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._sample_times import System
from compensator_theory.systems._state_space import transfer_matrix_of_realisation
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix

IDENTITY = "P E Q = diag(I, N), P A Q = diag(J, I), N nilpotent, det P and det Q not 0"
RESPONSE = "({0}E - A) X = det({0}I - J) B"


@dataclass(frozen=True)
class WeierstrassForm(ExactValue):
    r"""A regular pencil taken apart into its slow part, of finite modes, and its fast part.

    .. math:: P E Q = \begin{bmatrix} I & 0 \\ 0 & N \end{bmatrix}, \qquad
              P A Q = \begin{bmatrix} J & 0 \\ 0 & I \end{bmatrix}, \qquad N^{\nu} = 0

    Attributes
    ----------
    P, Q : sympy.ImmutableMatrix
        n x n, nonsingular.
    J, N : sympy.ImmutableMatrix
        Of the slow part, whose eigenvalues are the finite modes, and of the fast part, nilpotent.
        Neither is brought to Jordan's form.
    index : int
        :math:`\nu`, the least with N^nu = 0: 0 where E is nonsingular, 1 without impulses.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the form holds where none of them is zero.
    certificate : Certificate
        The two products, computed anew, and N^nu.
    """

    P: ImmutableMatrix
    Q: ImmutableMatrix
    J: ImmutableMatrix
    N: ImmutableMatrix
    index: int
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def __str__(self) -> str:
        return (
            f"{self.J.rows} finite modes, {self.N.rows} states of the fast part, index {self.index}"
        )

    def _repr_latex_(self) -> str:
        return displayed(
            f"J = {latex(self.J)}, \\quad N = {latex(self.N)}",
            f"P = {latex(self.P)}, \\quad Q = {latex(self.Q)}",
            unless(self.exceptional),
        )


@dataclass(frozen=True, init=False)
class DescriptorSystem(System):
    r"""A system of differential or difference equations together with algebraic ones.

    .. math:: E \dot x = A x + B u, \qquad y = C x + D u, \qquad
              G = C (sE - A)^{-1} B + D

    Circuits, mechanisms with constraints and interconnections come in this form, and so does an
    improper transfer function. Every function that reads a transfer function or a transfer matrix
    reads one, and those that read a realisation do where it is proper.

    Parameters
    ----------
    E, A, B, C, D : matrix
        n x n, n x n, n x m, p x n, p x m, read by :func:`exact_number`; D = None means zero.
    variable : str or Symbol
        Variable of the transfer functions; default ``s``. For ``z`` and ``q`` read
        :math:`x(k+1)` for :math:`\dot x`.
    sample_time : number, optional
        As of :class:`TransferFunction`.

    Raises
    ------
    InputError
        If the shapes do not fit, or :math:`\det(sE - A) = 0` for all s: some input has then no
        solution, or several.

    Notes
    -----
    Source: L. Dai, Singular Control Systems (1989); G.-R. Duan, Analysis and Design of Descriptor
    Linear Systems (2010).

    Examples
    --------
    >>> from compensator_theory import DescriptorSystem
    >>> circuit = DescriptorSystem(  # capacitor c and resistor r in series at a voltage u; current
    ...     [["c", 0], [0, 0]], [[0, 1], [1, "r"]], [[0], [-1]], [[0, 1]])
    >>> print(circuit.transfer_function(), circuit.index)
    (s/r)/(s + 1/(c*r)) 1
    >>> twice = DescriptorSystem([[0, 1], [0, 0]], [[1, 0], [0, 1]], [[0], [1]], [[-1, 0]])
    >>> print(twice.transfer_function(), twice.index, twice.is_impulse_free)  # a differentiator
    (s)/(1) 2 False
    """

    E: ImmutableMatrix
    A: ImmutableMatrix
    B: ImmutableMatrix
    C: ImmutableMatrix
    D: ImmutableMatrix
    variable: Symbol
    sample_time: Rational | None = None

    def __init__(
        self,
        E: MatrixLike,
        A: MatrixLike,
        B: MatrixLike,
        C: MatrixLike,
        D: MatrixLike | None = None,
        variable: str | Symbol = "s",
        sample_time: NumberLike | None = None,
    ) -> None:
        rest = Realisation(A, B, C, D, variable, sample_time=sample_time)
        e = exact_matrix(E, "E")
        if e.shape != rest.A.shape:
            raise InputError(
                f"E is {e.rows} x {e.cols} but must be {rest.n} x {rest.n}, as A is square and has "
                f"{rest.n} rows"
            )
        if rest.variable in symbols_in(e):
            raise InputError(
                f"E contains {rest.variable}, the variable of the transfer function; name another "
                "one with variable="
            )
        require_one_symbol_a_name({rest.variable}.union(*map(symbols_in, (e, *rest.matrices))))
        object.__setattr__(self, "E", e)
        for name in ("A", "B", "C", "D", "variable", "sample_time"):
            object.__setattr__(self, name, getattr(rest, name))
        ask("entries", 4 * self.n**3, "a descriptor system")
        self._point()  # refuses a pencil that is not regular

    @property
    def n(self) -> int:
        """Number of equations, and of entries of x."""
        return int(self.A.rows)

    @property
    def is_siso(self) -> bool:
        """Whether there are one input and one output."""
        return bool(self.D.shape == (1, 1))

    @property
    def characteristic_polynomial(self) -> Poly:
        """The polynomial det(sE - A): its roots are the finite modes."""
        point, s = self._point(), self.variable
        self._ask_for_terms(1)
        resolvent, t = solve(point * self.E - self.A, self.E), s - point
        # det(sE - A) = det(s_0 E - A) det(I + (s - s_0) M), M = (s_0 E - A)^-1 E
        descending = characteristic_polynomial(resolvent, sympy.Dummy()).all_coeffs()
        whole = sum(c * (-t) ** k for k, c in enumerate(descending))
        scale = determinant(point * self.E - self.A)
        return canonical(Poly(sympy.cancel(sympy.expand(scale * whole)), s))

    @property
    def index(self) -> int:
        r"""The least nu with :math:`N^\nu = 0`, with symbols for generic values of them."""
        return self.weierstrass_form().index

    @property
    def is_impulse_free(self) -> bool | None:
        """Whether the index is at most 1, deg det(sE - A) = rank E; None if a symbol decides."""
        most = rank(self.E)
        leading = self.characteristic_polynomial.coeff_monomial(self.variable**most)
        if leading == 0:
            return None if self.E.free_symbols else False
        return True if leading.is_nonzero else None

    @property
    def is_controllable(self) -> bool | None:
        """Whether every finite mode feels the input; None if that depends on a symbol."""
        return None if self.weierstrass_form().exceptional else self.slow_part().is_controllable

    @property
    def is_observable(self) -> bool | None:
        """Whether every finite mode shows in the output; None if that depends on a symbol."""
        return self.dual().is_controllable

    @property
    def is_impulse_controllable(self) -> bool | None:
        r"""Whether feedback of x can remove all impulses; None if a symbol may decide.

        .. math:: \mathrm{rank} \begin{bmatrix} E & 0 & 0 \\ A & E & B \end{bmatrix}
                  = n + \mathrm{rank}\,E
        """
        E, A, B = self.E, self.A, self.B
        if any(map(symbols_in, (E, A, B))):
            return None
        above = E.row_join(zero_matrix(self.n, self.n + B.cols))
        return bool(rank(above.col_join(A.row_join(E).row_join(B))) == self.n + rank(E))

    @property
    def is_impulse_observable(self) -> bool | None:
        """Whether every impulse of x shows in the output; None if a symbol may decide."""
        return self.dual().is_impulse_controllable

    @property
    def uncontrollable_modes(self) -> Poly:
        """Monic polynomial of the finite modes that the input does not reach; 1 without them."""
        return self.slow_part().uncontrollable_modes

    @property
    def unobservable_modes(self) -> Poly:
        """Monic polynomial of the finite modes that the output does not show; 1 without them."""
        return self.slow_part().unobservable_modes

    def dual(self) -> DescriptorSystem:
        """Return (E', A', C', B', D'), whose transfer matrix is the transpose."""
        E, A, C, B, D = (M.T for M in (self.E, self.A, self.C, self.B, self.D))
        return DescriptorSystem(E, A, C, B, D, self.variable, self.sample_time)

    def weierstrass_form(self) -> WeierstrassForm:
        r"""Separate slow and fast part, by Fitting's decomposition of (s_0 E - A)^-1 E.

        Raises
        ------
        BudgetError
            If it is too large.
        """
        point, length = self._point(), self._longest_chain()
        self._ask_for_terms(length)
        one = identity_matrix(self.n)
        if not length:  # E is nonsingular
            n_1, P, Q = self.n, solve(self.E, one), one
            divisors = [determinant(self.E)]
        else:
            pencil = ImmutableMatrix(point * self.E - self.A)
            M = solve(pencil, self.E)
            power = reduce(multiplied, [M] * length)
            reduced, image = echelon(power), echelon(ImmutableMatrix(power.T))
            n_1 = len(reduced.pivots)
            Q = joined(self.n, [image.matrix.T, reduced.kernel()])
            inside = solve(Q, multiplied(M, Q))
            slow, other = inside[:n_1, :n_1], identity_matrix(self.n - n_1)
            inverse = solve(slow, identity_matrix(n_1)) if n_1 else slow
            scale = sympy.diag(inverse, solve(point * inside[n_1:, n_1:] - other, other))
            P = multiplied(scale, solve(Q, solve(pencil, one)))
            divisors = [determinant(pencil), reduced.divided_by, image.divided_by, determinant(Q)]
        E, A = (multiplied(P, X, Q) for X in (self.E, self.A))
        J, N = A[:n_1, :n_1], E[n_1:, n_1:]
        index, nilpotent = 0, identity_matrix(N.rows)
        while not nilpotent.is_zero_matrix and index <= N.rows:
            nilpotent, index = multiplied(nilpotent, N), index + 1
        divisors += denominators_of((P, Q, J, N))
        singular = sympy.Integer(rank(P) < self.n or rank(Q) < self.n)
        left = [
            E - sympy.diag(identity_matrix(n_1), N),
            A - sympy.diag(J, identity_matrix(N.rows)),
            nilpotent,
        ]
        left.append([singular])
        certificate = certificate_of(IDENTITY, left, "Weierstrass form")
        P, Q, J, N = map(ImmutableMatrix, (P, Q, J, N))
        index = index if N.rows else 0
        return WeierstrassForm(P, Q, J, N, index, exceptional_factors(divisors), certificate)

    def slow_part(self) -> Realisation:
        """Return the strictly proper part (J, B_1, C_1) with all finite modes."""
        form = self.weierstrass_form()
        n_1 = form.J.rows
        B, C = multiplied(form.P, self.B), multiplied(self.C, form.Q)
        return Realisation(
            form.J, B[:n_1, :], C[:, :n_1], None, self.variable, sample_time=self.sample_time
        )

    def transfer_matrix(self) -> TransferMatrix:
        r"""Return C (sE - A)^-1 B + D over det(sI - J), improper where impulses reach an output.

        .. math:: G = C_1 (sI - J)^{-1} B_1 + D - \sum_{k < \nu} C_2 N^k B_2\,s^k

        Its certificate is the identity (sE - A) X = det(sI - J) B of the response of x.
        """
        s = self.variable
        if not self.n:
            return self.realisation().transfer_matrix()
        X = self._response()
        left = _over_one([-self.A, self.E], s) @ X - self.B
        entries = [entry.as_expr() for row in left.numerators for entry in row]
        certificate = certificate_of(RESPONSE.format(s), [entries], "response")
        G = self.C @ X + self.D
        return TransferMatrix(G.numerators, G.denominator, certificate, self.sample_time)

    def _response(self) -> TransferMatrix:
        """Return (sE - A)^-1 B over det(sI - J)."""
        form, s = self.weierstrass_form(), self.variable
        n_1, B = form.J.rows, multiplied(form.P, self.B)
        parts = []
        if n_1:
            zero = sympy.zeros(n_1, B.cols)
            slow = transfer_matrix_of_realisation(form.J, B[:n_1, :], identity_matrix(n_1), zero, s)
            parts.append(form.Q[:, :n_1] @ slow)
        if form.N.rows:
            powers = [-B[n_1:, :]]
            for _ in range(form.index - 1):
                powers.append(multiplied(form.N, powers[-1]))
            parts.append(form.Q[:, n_1:] @ _over_one(powers, s))
        total: TransferMatrix = reduce(add, parts)
        return total

    def transfer_function(self) -> TransferFunction:
        """Return the only entry of the transfer matrix; InputError if there are several."""
        return self.transfer_matrix().scalar()

    def realisation(self) -> Realisation:
        """Return (J, B_1, C_1, D - C_2 B_2), all finite modes kept.

        Raises
        ------
        ImproperError
            If an impulse reaches an output: the transfer matrix is improper.
        """
        form = self.weierstrass_form()
        n_1 = form.J.rows
        B, C = multiplied(form.P, self.B), multiplied(self.C, form.Q)
        term = B[n_1:, :]
        direct = self.D - C[:, n_1:] * term
        for k in range(1, form.index):
            term = multiplied(form.N, term)
            if not multiplied(C[:, n_1:], term).is_zero_matrix:
                raise ImproperError(
                    f"the transfer matrix of this descriptor system has the power {k} of "
                    f"{self.variable} in it; it has no realisation (A, B, C, D)"
                )
        return Realisation(
            form.J, B[:n_1, :], C[:, :n_1], in_lowest_terms(direct), self.variable,
            sample_time=self.sample_time,
        )  # fmt: skip

    def _point(self) -> int:
        """Return an integer s_0 with s_0 E - A nonsingular; n + 1 are enough to find one."""
        points = [(k + 1) // 2 * (-1 if k % 2 else 1) for k in range(self.n + 1)]  # 0, -1, 1, ...
        for E, A in (
            self._at_numbers(),
            (self.E, self.A),
        ):  # nonsingular there, so for generic ones
            for point in points:
                if rank(point * E - A) == self.n:
                    return point
        raise InputError(
            f"det({self.variable}E - A) is 0 for every {self.variable}: the equations contradict "
            "or repeat each other, so that x is not determined by u; look for one that is there "
            "twice, or for an unknown without an equation"
        )

    def _longest_chain(self) -> int:
        """The least k from which on M^k, M = (s_0 E - A)^-1 E, keeps its rank: the index.

        With symbols it is that for numbers in their places, by chance smaller than the generic one;
        the certificate of the form would tell.
        """
        E, A = self._at_numbers()
        M = solve(self._point() * E - A, E)
        power, before, k = M, self.n, 0
        while (now := rank(power)) < before:
            power, before, k = multiplied(power, M), now, k + 1
        return k

    def _at_numbers(self) -> tuple[ImmutableMatrix, ImmutableMatrix]:
        """Return E and A with large fixed integers substituted for the symbols."""
        numbers = random.Random(self.n)
        values = {symbol: sympy.Integer(numbers.getrandbits(40)) for symbol in self._symbols()}
        return in_lowest_terms(self.E.subs(values)), in_lowest_terms(self.A.subs(values))

    def _symbols(self) -> list[Symbol]:
        return sorted(symbols_in(self.E) | symbols_in(self.A), key=str)

    def _ask_for_terms(self, length: int) -> None:
        """Check the budget for the terms of an entry of M^length, by its degree in the symbols."""
        if symbols := self._symbols():
            sides = (part for M in (self.E, self.A) for e in M for part in e.as_numer_denom())
            degree = max(Poly(side, *symbols).total_degree() for side in sides)
            degree *= self.n * max(1, length)
            ask("terms", math.comb(degree + len(symbols), len(symbols)), "the Weierstrass form")

    def __str__(self) -> str:
        names = ("E", "A", "B", "C") + (() if self.D.is_zero_matrix else ("D",))
        return "\n".join(matrix_line(name, getattr(self, name)) for name in names)

    def _repr_latex_(self) -> str:
        rows = (latex(getattr(self, name)) for name in "EABCD")
        names = ("E", "A", "B", "C", "D")
        return displayed(*(f"{name} = {row}" for name, row in zip(names, rows, strict=True)))


def _over_one(ascending: Sequence[Matrix], variable: Symbol) -> TransferMatrix:
    """Return a polynomial matrix, given by its coefficients, as a transfer matrix."""
    rows, columns = ascending[0].shape
    entries = tuple(
        tuple(from_coefficients([M[i, j] for M in reversed(ascending)], variable)
              for j in range(columns))
        for i in range(rows)
    )  # fmt: skip
    return TransferMatrix(entries, canonical(Poly(1, variable)))
