"""Every state feedback that places given poles, by its free parameters."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory._printing import text
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.forms._frobenius import frobenius_form
from compensator_theory.matrices._certificates import Certified, Residuals
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._flint_matrices import identity_matrix, zero_matrix
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    in_lowest_terms,
    multiplied,
    rank,
    solve,
)
from compensator_theory.placement._brunovsky import BrunovskyForm, brunovsky_form
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._from_roots import SpectrumLike, polynomial_or_roots
from compensator_theory.polynomials._letters import fresh, names_in_all, variable_for_matrix
from compensator_theory.polynomials._poly import canonical, monic, total
from compensator_theory.polynomials._values import ExactValue

TRIES = 60


@dataclass(frozen=True)
class StateFeedbackFamily(Certified, ExactValue):
    r"""All gains K that make A + B K similar to one matrix.

    .. math:: A X(\Phi) + B G(\Phi) = X(\Phi)\,\Lambda, \qquad K = G(\Phi)\,X(\Phi)^{-1}

    X and G are linear in the parameters, an m x n matrix. Every K with A + B K similar to
    :math:`\Lambda` comes from one of them with det X nonzero, and :math:`\Phi S` gives the K of
    :math:`\Phi` for every S that commutes with :math:`\Lambda`.

    Attributes
    ----------
    form : BrunovskyForm
        Of (A, B).
    Lambda : sympy.ImmutableMatrix
        n x n: A + B K in the basis X.
    polynomial : sympy.Poly
        Its characteristic polynomial.

    Notes
    -----
    With :math:`(sI - A)S(s) = B D(s)` from the chains of integrators, the columns of X and G are
    S and D with :math:`\Lambda` in place of s, so that common eigenvalues of A and
    :math:`\Lambda` need no exception.
    """

    _CARRIES = True

    identity = "A X + B G = X Lambda for every parameter, det(sI - Lambda) = p"

    form: BrunovskyForm
    Lambda: ImmutableMatrix
    polynomial: Poly

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of inputs and of states: the shape of K and of the parameters."""
        return len(self.form.indices), int(self.Lambda.rows)

    @property
    def exceptional(self) -> tuple[Expr, ...]:
        """Polynomials in the symbols of (A, B) at whose zeros its form does not hold."""
        return self.form.exceptional

    def _residuals(self) -> Residuals:
        r"""Return residuals whose vanishing proves the identity for every parameter.

        With (A + BF) T = T A_c and B W = T B_c, the identity is that of the chains of integrators:
        the rows :math:`\phi_i\Lambda^k` of X and those at their ends cancel, whatever they are.
        """
        spectrum = characteristic_polynomial(self.Lambda, self.polynomial.gen)
        yield total(spectrum, self.polynomial * -1)
        yield from self.form._residuals()

    def basis(self, parameters: MatrixLike) -> ImmutableMatrix:
        """Return X: its columns are those in which A + B K is Lambda."""
        return in_lowest_terms(self.form.T * self._stacked(self._read(parameters))[0])

    def determinant(self, parameters: MatrixLike) -> Expr:
        """Return det X; the gain exists where it is not zero."""
        return determinant(self.basis(parameters))

    def gain(self, parameters: MatrixLike | None = None) -> ImmutableMatrix:
        """Return K, m x n, for m x n parameters; for some small integers if none are given.

        Raises
        ------
        NoSolutionError
            If det X is zero: these parameters belong to no gain.
        InputError
            If the shape is wrong, or a symbol of theirs is one of the plant.
        """
        if parameters is None:
            return self.gain(next(self._members()))
        phi = self._read(parameters)
        below, top = self._stacked(phi)
        # K T = F T + W top below^-1
        try:
            moved = solve(below.T, top.T).T
        except NoSolutionError as error:
            raise NoSolutionError(
                f"det X = 0 for the parameters {phi.tolist()}: no gain belongs to them"
            ) from error
        inverse = solve(self.form.T, identity_matrix(self.shape[1]))
        K = in_lowest_terms(self.form.F + self.form.W * moved * inverse)
        self._require(K, multiplied(self.form.T, below))
        return K

    def parameters_of(self, K: MatrixLike) -> tuple[ImmutableMatrix, ...]:
        """Return a basis of all parameters that satisfy G = K X; empty if K is none of the family.

        Those with det X nonzero give K back. K is one of the family where A + B K is similar to
        Lambda: its characteristic polynomial alone is not enough.
        """
        gain = exact_matrix(K, "K")
        m, n = self.shape
        if gain.shape != (m, n):
            raise InputError(f"K is {gain.rows} x {gain.cols}; it must be {m} x {n}")
        if not are_similar(in_lowest_terms(self.form.A + self.form.B * gain), self.Lambda):
            return ()
        images = [(G - gain * X).reshape(m * n, 1) for X, G in self._columns()]
        kernel = _kernel(ImmutableMatrix.hstack(*images))
        return tuple(ImmutableMatrix(m, n, list(column)) for column in kernel)

    def _columns(self) -> Iterator[tuple[ImmutableMatrix, ImmutableMatrix]]:
        """Yield (X, G) for each unit matrix of the parameters, in which both are linear."""
        m, n = self.shape
        for position in range(m * n):
            below, top = self._stacked(
                ImmutableMatrix(m, n, [int(k == position) for k in range(m * n)])
            )
            X = multiplied(self.form.T, below)
            yield X, multiplied(self.form.F, X) + multiplied(self.form.W, top)

    def _members(self) -> Iterator[ImmutableMatrix]:
        """Yield small integers with det X nonzero, the same ones each time."""
        m, n = self.shape
        draw = random.Random(0)
        for height in range(TRIES):
            top = 1 + height // 10
            entries = [draw.randint(-top, top) for _ in range(m * n)]
            candidate = ImmutableMatrix(m, n, entries)
            if self.determinant(candidate) != 0:
                yield candidate
        raise NoSolutionError(
            f"no gain makes A + BK similar to {self.Lambda.tolist()}: its invariant polynomials "
            f"would need larger controllability indices than {self.form.indices} (Rosenbrock's "
            "inequalities); request larger Jordan blocks"
        )

    def _stacked(self, phi: ImmutableMatrix) -> tuple[ImmutableMatrix, ImmutableMatrix]:
        """Return the rows phi_i Lambda^k below the index of each chain, and those at it."""
        below, tops = [zero_matrix(0, self.shape[1])], []
        for i, length in enumerate(self.form.indices):
            row = phi[i, :]
            for _ in range(length):
                below.append(row)
                row = multiplied(row, self.Lambda)
            tops.append(row)
        return ImmutableMatrix.vstack(*below), ImmutableMatrix.vstack(*tops)

    def _read(self, parameters: MatrixLike) -> ImmutableMatrix:
        phi = exact_matrix(parameters, "the parameters")
        if phi.shape != self.shape:
            raise InputError(
                f"the parameters are {phi.rows} x {phi.cols}; they must be "
                f"{self.shape[0]} x {self.shape[1]}"
            )
        return phi

    def _require(self, K: ImmutableMatrix, X: ImmutableMatrix) -> None:
        """Refuse to hand out a gain that does not make A + B K similar to Lambda, by X.

        That X is not singular is known from the solution for K. A characteristic polynomial of
        A + B K would have to be computed from numbers as long as those of K, all n^2 of them.
        """
        closed = multiplied(self.form.A, X) + multiplied(self.form.B, multiplied(K, X))
        spectrum = characteristic_polynomial(self.Lambda, self.polynomial.gen)
        if spectrum != self.polynomial or closed != multiplied(X, self.Lambda):
            raise NoSolutionError(f"K = {K.tolist()} is wrong, please report it")

    def __str__(self) -> str:
        m, n = self.shape
        s = self.polynomial.gen
        return (
            f"all {m} x {n} gains with det({s}I - A - BK) = {format_polynomial(self.polynomial)}"
            f"{self.structure}, by {m} x {n} parameters"
        )

    @property
    def structure(self) -> str:
        """The block structure of A + B K in words; empty if the polynomial determines it."""
        if len(self.form.indices) == 1 or self.polynomial.is_sqf:
            return ""  # every matrix with this characteristic polynomial is similar to Lambda
        if frobenius_form(self.Lambda).is_cyclic:
            return " and A + BK cyclic"
        return f" and A + BK similar to {text(self.Lambda.tolist())}"

    def _repr_latex_(self) -> str:
        s, (m, n) = latex(self.polynomial.gen), self.shape
        return displayed(
            rf"K = G(\Phi)\, X(\Phi)^{{-1}}, \quad \Phi \in \mathbb{{R}}^{{{m} \times {n}}}",
            rf"\det({s} I - A - B K) = {latex(self.polynomial)}",
            rf"A + B K \sim {latex(self.Lambda)}" if self.structure else "",
            unless(self.exceptional),
        )


@carrying()
def state_feedback_family(
    A: MatrixLike,
    B: MatrixLike,
    poles: SpectrumLike | None = None,
    *,
    Lambda: MatrixLike | None = None,
    variable: str | Symbol | None = None,
) -> StateFeedbackFamily:
    r"""Find every K that places the eigenvalues of A + B K.

    Parameters
    ----------
    A, B : matrix
        n x n and n x m, controllable; with symbols, for generic values of them.
    poles : polynomial or list of roots
        Of degree n; a list holds its *roots*. A + B K is then cyclic: each repeated eigenvalue has
        one Jordan block.
    variable : str or Symbol, optional
        Variable of the polynomial; default: s, or lambda where the matrices have a symbol s.
    Lambda : matrix, optional
        In place of `poles`: n x n, similar to A + B K, for other Jordan structures.

    Raises
    ------
    NotControllableError
        If (A, B) is not controllable; the message names the fixed modes.
    InputError
        If the number of poles is not n, or both or none of `poles` and `Lambda` are given.

    Notes
    -----
    Source: for the equation A X + B G = X Lambda, S. P. Bhattacharyya and E. de Souza, Systems and
    Control Letters 1 (1982); for the possible structures, H. H. Rosenbrock, State-space and
    Multivariable Theory (1970).

    Examples
    --------
    >>> from compensator_theory import state_feedback_family
    >>> A, B = [[0, 1, 0], [0, 0, 0], [0, 0, 1]], [[0, 0], [1, 0], [1, 1]]
    >>> family = state_feedback_family(A, B, [-1, -2, -3])
    >>> print(family)
    all 2 x 3 gains with det(sI - A - BK) = s**3 + 6*s**2 + 11*s + 6, by 2 x 3 parameters
    >>> family.gain([[1, 0, 0], [0, 0, 1]])
    Matrix([
    [-1, -1,  1],
    [ 0, -4, -7]])
    """
    if (poles is None) == (Lambda is None):
        raise InputError(
            "give either the poles or, as Lambda= to state_feedback_family, the matrix that A + BK "
            "is similar to"
        )
    form = brunovsky_form(A, B)
    n = form.A.rows
    spectrum = None if Lambda is None else exact_matrix(Lambda, "Lambda")
    symbol = variable_for_matrix(variable, form.A, form.B, spectrum)
    if spectrum is not None:
        if spectrum.shape != (n, n):
            raise InputError(
                f"Lambda is {spectrum.rows} x {spectrum.cols}; A + BK has {n} eigenvalues"
            )
        return StateFeedbackFamily(form, spectrum, characteristic_polynomial(spectrum, symbol))
    assert poles is not None
    goal = monic(polynomial_or_roots(poles, symbol))
    if goal.degree() != n:
        raise InputError(
            f"{format_polynomial(goal)} has degree {goal.degree()}, but {n} eigenvalues are to be "
            "placed"
        )
    companion = Matrix.zeros(n, n)
    for k in range(n - 1):
        companion[k, k + 1] = 1
    for k in range(n):
        companion[n - 1, k] = -goal.coeff_monomial(symbol**k)
    return StateFeedbackFamily(form, exact_matrix(companion, "Lambda"), canonical(goal))


def are_similar(first: Matrix, second: Matrix) -> bool:
    """Tell whether two matrices of one size are similar; with symbols, for generic values.

    They are if and only if M X = X L has as many solutions as M X = X M and L X = X L (C. I. Byrnes
    and M. A. Gauger, Advances in Mathematics 24 (1977)).
    """
    s = fresh(names_in_all(first, second), "s")
    if characteristic_polynomial(first, s) != characteristic_polynomial(second, s):
        return False
    unit = identity_matrix(first.rows)

    def commutant(left: Matrix, right: Matrix) -> int:
        product = sympy.kronecker_product
        return rank(ImmutableMatrix(product(unit, left) - product(right.T, unit)))

    mixed = commutant(first, second)
    return mixed == commutant(first, first) == commutant(second, second)


def _kernel(matrix: ImmutableMatrix) -> list[ImmutableMatrix]:
    from_rows = echelon(matrix).kernel()
    return [from_rows[:, k] for k in range(from_rows.cols)]
