"""The Frobenius form of a matrix, with the basis that leads to it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.errors import InputError
from compensator_theory.forms._smith import smith_form
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._exceptional_factors import denominators_of, exceptional_factors
from compensator_theory.matrices._flint_matrices import (
    RationalMatrix,
    from_flint,
    identity_matrix,
    rational_in_flint,
)
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    in_lowest_terms,
    multiplied,
)
from compensator_theory.matrices._residues import large_prime
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._letters import variable_for_matrix
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._controllability import krylov

IDENTITY = "A T = T A_F, det T not 0, each invariant polynomial a divisor of the next"


@dataclass(frozen=True)
class FrobeniusForm(ExactValue):
    r"""A matrix as a direct sum of companion matrices.

    .. math:: A T = T A_F, \qquad A_F = \mathrm{diag}(C_{\lambda_1}, \ldots, C_{\lambda_k}), \qquad
              \lambda_i \mid \lambda_{i+1}

    Attributes
    ----------
    form : sympy.ImmutableMatrix
        :math:`A_F`, n x n; each block has ones below its diagonal and the coefficients of its
        polynomial, negative, in its last column. It is unique, and two matrices are similar if and
        only if they share it.
    T : sympy.ImmutableMatrix
        The basis: for each block a generator g and A g, A^2 g, ...; one of many.
    invariant_polynomials : tuple of sympy.Poly
        Monic, of degree 1 or more. The last is the minimal polynomial, their product det(sI - A).
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the form holds where none of them is zero.
    certificate : Certificate
        A T - T A_F, computed anew; T is nonsingular and the polynomials divide each other.
    """

    form: ImmutableMatrix
    T: ImmutableMatrix
    invariant_polynomials: tuple[Poly, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def minimal_polynomial(self) -> Poly:
        """The monic polynomial of least degree with p(A) = 0."""
        return self.invariant_polynomials[-1]

    @property
    def is_cyclic(self) -> bool:
        """Whether there is one block only; a matrix with several is derogatory."""
        return len(self.invariant_polynomials) == 1

    def __str__(self) -> str:
        return "companions of " + ", ".join(map(format_polynomial, self.invariant_polynomials))

    def _repr_latex_(self) -> str:
        return displayed(
            rf"A = T A_F T^{{-1}}, \quad A_F = {latex(self.form)}",
            f"T = {latex(self.T)}",
            unless(self.exceptional),
        )


@carrying()
def frobenius_form(A: MatrixLike, variable: str | Symbol | None = None) -> FrobeniusForm:
    r"""Bring a matrix to its Frobenius form, the rational canonical form.

    .. math:: U (sI - A) V = \mathrm{diag}(1, \ldots, \lambda_1, \ldots, \lambda_k), \qquad
              g_i = \sum_j A^j\,(U^{-1})_{i,j} \quad\text{for}\quad
              U^{-1} e_i = \sum_j (U^{-1})_{i,j}\,s^j

    Parameters
    ----------
    A : matrix
        n x n, n >= 1; with symbols, for generic values of them.
    variable : str or Symbol, optional
        Of the polynomials; default: s, or lambda where A has a symbol s.

    Raises
    ------
    InputError, BudgetError
        If the matrix is not square or empty, or too large.

    Notes
    -----
    Where a unit vector, or their sum, is cyclic, its Krylov matrix is the basis, and no Smith form
    is needed. Source: G. Frobenius (1879); F. R. Gantmacher, The Theory of Matrices, VI.4, VII.5.

    Examples
    --------
    >>> from compensator_theory.forms import frobenius_form
    >>> form = frobenius_form([[3, -1, 2, -1], [1, 1, 2, -1], [-1, 1, 1, 1], [-2, 2, -2, 4]])
    >>> print(form)
    companions of s - 2, s**3 - 7*s**2 + 16*s - 12
    >>> frobenius_form([["a", 1], [0, "b"]]).exceptional
    ()
    """
    a = exact_matrix(A, "A")
    s = variable_for_matrix(variable, a)
    if a.rows != a.cols or not a.rows:
        raise InputError(f"A is {a.rows} x {a.cols}; a square matrix is needed")
    cyclic = _cyclic(a)
    divisors: list[Expr]
    if cyclic is not None:
        T, minor = cyclic
        polynomials, divisors = (characteristic_polynomial(a, s),), [minor]
    else:
        ask("entries", 4 * a.rows**3, "the Frobenius form")
        T, polynomials, divisors = _by_smith_form(a, s)
        divisors.append(determinant(T))
    form = _companions(polynomials)
    singular = sympy.Integer(any(divisor == 0 for divisor in divisors))  # det T is among them
    left = [a * T - T * form, [singular]]
    for smaller, larger in pairwise(polynomials):
        x, y = larger.unify(smaller)
        field = x.domain.get_field()
        left.append(x.set_domain(field).rem(y.set_domain(field)).all_coeffs())
    return FrobeniusForm(
        form,
        T,
        polynomials,
        exceptional_factors([*divisors, *denominators_of((a, T, form))]),
        certificate_of(IDENTITY, left),
    )


def _cyclic(a: ImmutableMatrix) -> tuple[ImmutableMatrix, Expr] | None:
    """Return the Krylov matrix of a simple cyclic vector, and its determinant or a factor of it."""
    if (raw := rational_in_flint(a)) is not None:
        T = _cyclic_of_numbers(raw)
        return None if T is None else (T, sympy.Integer(1))
    n, symbols = a.rows, sorted(a.free_symbols, key=str)
    ask("entries", 4 * n**3, "the Frobenius form")
    for start in _starts(n):
        columns, degree, written = [Matrix(start)], 0, 0
        for _ in range(n - 1):
            columns.append(multiplied(a, columns[-1]))
            degree += _degree(columns[-1], symbols)
            written += sum(bool(entry.free_symbols) for entry in columns[-1])
            terms = written * math.comb(degree + len(symbols), degree) // 2
            ask("terms", terms, "the Frobenius form with symbols")
        T = ImmutableMatrix.hstack(*columns)
        minor = sympy.cancel(determinant(T))
        if minor != 0:
            return ImmutableMatrix(T), minor
    return None


def _starts(n: int) -> list[list[int]]:
    """Return the vectors that are tried: unit vectors, their sum, and 1, 2, ..., n."""
    return [*([int(i == k) for i in range(n)] for k in range(n)), [1] * n, [*range(1, n + 1)]]


def _cyclic_of_numbers(a: flint.fmpq_mat) -> RationalMatrix | None:
    """Return the Krylov matrix of the first vector that is cyclic modulo a prime, and so cyclic."""
    n, whole = int(a.nrows()), a.numer_denom()
    prime = large_prime()
    residues = flint.nmod_mat(whole[0], prime)
    if residues.minpoly().degree() < n:
        return None
    for start in _starts(n):
        if krylov(residues, flint.nmod_mat(n, 1, start, prime)).rank() == n:
            longest = max(int(entry) for entry in (whole[1], *map(abs, whole[0].entries()))) * n
            ask("entries", n**3 * longest.bit_length() // 512, "the basis in numbers of 512 bits")
            return from_flint(krylov(a, flint.fmpq_mat(n, 1, start)).transpose())
    return None


def _degree(column: Matrix, symbols: list[Symbol]) -> int:
    """Return the highest total degree of a numerator or denominator of rational functions."""
    sides = (side for entry in column for side in entry.as_numer_denom())
    return max(Poly(side, *symbols).total_degree() if symbols else 0 for side in sides)


def _by_smith_form(
    a: ImmutableMatrix, s: Symbol
) -> tuple[ImmutableMatrix, tuple[Poly, ...], list[Expr]]:
    n = a.rows
    smith = smith_form(s * identity_matrix(n) - a, s)
    blocks, polynomials = [], []
    for i in range(n):
        invariant = smith.form[i, i]
        if invariant.degree() == 0:
            continue
        polynomials.append(canonical(invariant))
        column = [row[i] for row in smith.U_inverse.rows]
        highest = max(int(e.degree()) for e in column if not e.is_zero)
        generator = sympy.zeros(n, 1)
        for k in range(highest, -1, -1):  # Horner's rule in A
            generator = in_lowest_terms(
                a * generator + Matrix([entry.coeff_monomial(s**k) for entry in column])
            )
        for _ in range(int(invariant.degree())):
            blocks.append(generator)
            generator = multiplied(a, generator)
    return ImmutableMatrix.hstack(*blocks), tuple(polynomials), list(smith.exceptional)


def _companions(polynomials: tuple[Poly, ...]) -> ImmutableMatrix:
    n = sum(int(p.degree()) for p in polynomials)
    form, start = Matrix.zeros(n, n), 0
    for p in polynomials:
        size = int(p.degree())
        for k in range(size):
            if k:
                form[start + k, start + k - 1] = 1
            form[start + k, start + size - 1] = -p.coeff_monomial(p.gen**k)
        start += size
    return ImmutableMatrix(form)
