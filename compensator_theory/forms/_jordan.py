"""The Jordan form of a matrix, over the rationals, the reals or the complex numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, Poly

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._cyclic_families import krylov
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._exceptional_factors import denominators_of, exceptional_factors
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.matrices._invariant_subspaces import (
    PrimaryComponent,
    evaluate,
    joined,
    primary_components,
)
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    rank,
)
from compensator_theory.matrices._nonsingularity import is_proven_nonsingular
from compensator_theory.polynomials._budget import ask, repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._letters import fresh, names_in_all
from compensator_theory.polynomials._reading import is_one_of
from compensator_theory.polynomials._values import ExactValue

IDENTITY = "A T = T J, det T not 0"


@dataclass(frozen=True)
class JordanForm(ExactValue):
    r"""A matrix as a direct sum of blocks with one eigenvalue, pair or irreducible factor each.

    .. math:: A T = T J, \qquad J = \mathrm{diag}(J_1, J_2, \ldots)

    Attributes
    ----------
    form, T : sympy.ImmutableMatrix
        J and the basis, n x n.
    blocks : tuple of pairs of sympy.Poly and int
        For each block over the rationals its irreducible factor and its length; over the reals and
        the complex numbers it has one block of that length for each root or pair of roots.
    over : str
        "rational", "real" or "complex".
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; J and T hold where none of them is zero. There a
        factor may still fall apart into factors of lower degree.
    certificate : Certificate
        A T - T J, computed anew, and a 0 for det T not 0: by the exact rank, or with square roots
        by a ball that contains det T and not 0.
    """

    form: ImmutableMatrix
    T: ImmutableMatrix
    blocks: tuple[tuple[Poly, int], ...]
    over: str
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def __str__(self) -> str:
        parts = [
            f"({format_polynomial(f)})" + (f"**{length}" if length > 1 else "")
            for f, length in self.blocks
        ]
        return f"{self.over} Jordan blocks of " + ", ".join(parts)

    def _repr_latex_(self) -> str:
        return displayed(
            f"J = {latex(self.form)}", f"T = {latex(self.T)}", unless(self.exceptional)
        )


@carrying()
def jordan_form(A: MatrixLike, *, over: str = "rational") -> JordanForm:
    r"""Bring a matrix to its Jordan form, generalised to factors that have no rational root.

    .. math:: J_i = \begin{bmatrix} C_f & N \\ & C_f & N \\ & & \ddots \end{bmatrix}, \qquad
              T_i = \begin{bmatrix} f^{k-1} v & A f^{k-1} v & \cdots & v & A v & \cdots
              \end{bmatrix}, \quad f = f(A)

    with the companion matrix of an irreducible factor f of degree d, and N with a single one, in
    its upper right corner; for d = 1 this is the usual Jordan block.

    Parameters
    ----------
    A : matrix
        n x n, n >= 1; with symbols, for generic values of them.
    over : {"rational", "real", "complex"}
        "complex" splits every factor into its roots, "real" gives a pair :math:`p \pm jq` the modal
        form with blocks [[p, q], [-q, p]]. Both are for factors of degree 1 and 2; whether a pair
        of roots with symbols is real depends on their values, so that it is for "complex".

    Raises
    ------
    InputError, BudgetError
        If the matrix is not square, has irrational numbers, or is too large, `over` is another
        word, or a factor has no roots to split into.

    Notes
    -----
    Chains begin with vectors v of :math:`\ker f^k` that are independent modulo :math:`\ker
    f^{k-1} + f \ker f^{k+1}`; a root r has the chain of :math:`(f/(s - r))^k(A) v`. Source: F. R.
    Gantmacher, The Theory of Matrices (1959), VII.5; B. D. H. Perlis, Theory of Matrices (1952).

    Examples
    --------
    >>> from compensator_theory.forms import jordan_form
    >>> form = jordan_form([[0, 1, 0], [0, 0, 1], [2, -5, 4]])
    >>> print(form, form.form)
    rational Jordan blocks of (s - 2), (s - 1)**2 Matrix([[2, 0, 0], [0, 1, 1], [0, 0, 1]])
    >>> jordan_form([[0, 1], [-5, -2]], over="real").form
    Matrix([
    [-1,  2],
    [-2, -1]])
    >>> form = jordan_form([["a", 1], [0, "b"]])
    >>> print(form, form.exceptional)
    rational Jordan blocks of (s - b), (s - a) (a - b,)
    """
    if not is_one_of(over, ("rational", "real", "complex")):
        raise InputError(f"over = {repr_of(over)} must be 'rational', 'real' or 'complex'")
    a = exact_matrix(A, "A")
    if a.rows != a.cols or not a.rows:
        raise InputError(f"A is {a.rows} x {a.cols}; a square matrix is needed")
    if not all(number.is_Rational for entry in a for number in entry.atoms(sympy.Number)) or any(
        not power.exp.is_Integer for power in a.atoms(sympy.Pow)
    ):
        raise InputError("A has irrational entries; rational numbers and symbols are needed")
    s = fresh(names_in_all(a), "s", "lambda", "s_")
    _ask(a)
    columns: list[Matrix] = []
    forms: list[Matrix] = []
    blocks: list[tuple[Poly, int]] = []
    divisors: list[Expr] = []
    rational: list[Matrix] = []  # a basis over the field of the entries
    for part in primary_components(a, characteristic_polynomial(a, s)):
        f = part.factor
        if over != "rational" and part.degree > 1:
            if part.degree > 2:
                raise InputError(
                    f"the factor {format_polynomial(f)} has degree {part.degree}, and its roots "
                    "are no square roots; over = 'rational' gives it separate blocks"
                )
            if over == "real" and f.free_symbols_in_domain:
                raise InputError(
                    f"whether {format_polynomial(f)} has real roots depends on the values of the "
                    "symbols; use over = 'complex' or 'rational'"
                )
            divisors.append(f.discriminant())
        for vector, length in _generators(a, part):
            blocks.append((f, length))
            rational += (basis for basis, _ in _blocks(a, f, vector, length, "rational"))
            for basis, form in _blocks(a, f, vector, length, over):
                columns.append(basis)
                forms.append(form)
    T, J = joined(a.rows, columns), ImmutableMatrix(sympy.diag(*forms))
    left = (a * T - T * J).applyfunc(_simple)
    if a.free_symbols:  # roots that differ split a nonsingular basis into a nonsingular one
        R = joined(a.rows, rational)
        divisors += [determinant(R), *denominators_of((a, R, J))]
        singular = sympy.Integer(any(sympy.cancel(divisor) == 0 for divisor in divisors))
    else:
        singular = sympy.Integer(not is_proven_nonsingular(T))  # 0 in a certificate that holds
    certificate = certificate_of(IDENTITY, [left, [singular]], "basis")
    return JordanForm(J, T, tuple(blocks), over, exceptional_factors(divisors), certificate)


def _ask(a: ImmutableMatrix) -> None:
    """Check the budget: digits of the entries and terms of a polynomial of the matrix."""
    n, symbols = a.rows, sorted(a.free_symbols, key=str)
    ask("entries", 4 * n**3, "the Jordan form")
    if symbols:
        degree = max(Poly(side, *symbols).total_degree() for e in a for side in e.as_numer_denom())
        terms = n**2 * math.comb(n * degree + len(symbols), len(symbols))
        ask("terms", terms, "the Jordan form with symbols")


def _simple(entry: Expr) -> Expr:
    """Multiply out and simplify squares of square roots."""
    if not entry.free_symbols:
        return sympy.expand(entry)
    top, bottom = sympy.fraction(sympy.together(entry))
    return sympy.expand(sympy.expand(top)) / bottom


def _generators(a: ImmutableMatrix, part: PrimaryComponent) -> list[tuple[Matrix, int]]:
    """Return one generator for each block and its length, longest first."""
    value, chains = evaluate(part.factor, a), []
    for k in range(part.multiplicity, 0, -1):
        above = part.kernels[min(k + 1, part.multiplicity)]
        span = joined(a.rows, [part.kernels[k - 1], value * above])
        size = rank(span)
        for column in range(part.kernels[k].cols):
            if size == part.kernels[k].cols:  # all of the kernel: no further chain begins here
                break
            vector = part.kernels[k][:, column]
            longer = joined(a.rows, [span, krylov(a, vector, part.degree)])
            if rank(longer) == size + part.degree:
                span, size = longer, size + part.degree
                chains.append((vector, k))
    return chains


def _blocks(
    a: ImmutableMatrix, f: Poly, vector: Matrix, length: int, over: str
) -> list[tuple[Matrix, Matrix]]:
    d, s = int(f.degree()), f.gen
    if over == "rational":
        value, chain = evaluate(f, a), [vector]
        for _ in range(length - 1):
            chain.append(value * chain[-1])
        basis = joined(a.rows, [krylov(a, v, d) for v in reversed(chain)])
        form = Matrix.zeros(d * length, d * length)
        for j in range(length):
            for i in range(d):
                if i + 1 < d:
                    form[d * j + i + 1, d * j + i] = 1
                form[d * j + i, d * j + d - 1] = -f.coeff_monomial(s**i)
            if j:
                form[d * (j - 1), d * j + d - 1] = 1
        return [(basis, form)]
    sizes = []
    roots = sympy.roots(f)
    if over == "real" and d == 2 and not all(root.is_real for root in roots):
        roots = [root for root in roots if sympy.im(root) > 0]
    for root in sorted(roots, key=sympy.default_sort_key):
        chain = _chain(a, f, vector, length, root)
        p, q = (root, sympy.S.Zero) if d == 1 else root.as_real_imag()
        if over == "complex" or q == 0:
            form = Matrix(length, length, lambda i, j, r=root: r if i == j else int(j == i + 1))
            sizes.append((joined(a.rows, chain), form))
        else:
            pairs = [part for v in chain for part in v.as_real_imag()]
            block, one = Matrix([[p, q], [-q, p]]), identity_matrix(2)
            shift = Matrix(length, length, lambda i, j: int(j == i + 1))
            form = sympy.kronecker_product(identity_matrix(length), block)
            sizes.append((joined(a.rows, pairs), form + sympy.kronecker_product(shift, one)))
    return sizes


def _chain(a: ImmutableMatrix, f: Poly, vector: Matrix, length: int, root: Expr) -> list[Matrix]:
    """Return the chain of one root of the block, the eigenvector first."""
    (linear,) = [-sum(sympy.roots(f)) + root] if f.degree() == 2 else [None]
    for _ in range(length if linear is not None else 0):  # f/(s - r) = s - other root
        vector = (a * vector + linear * vector).applyfunc(_simple)
    chain = [vector]
    for _ in range(length - 1):
        chain.append((a * chain[-1] - root * chain[-1]).applyfunc(_simple))
    return chain[::-1]
