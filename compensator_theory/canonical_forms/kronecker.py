"""Kronecker's canonical form of a pencil: minimal indices, finite and infinite structure."""

from dataclasses import dataclass
from math import lcm

import flint
import sympy
from sympy import Expr, Poly, Symbol

from compensator_theory.canonical_forms.minimal_bases import (
    MinimalBasis,
    basis_of_pencil,
    minimal_basis,
)
from compensator_theory.canonical_forms.pencil_kernels import Pencil
from compensator_theory.canonical_forms.regular_parts import (
    elementary_divisors,
    invariant_polynomials,
)
from compensator_theory.canonical_forms.smith import smith_form
from compensator_theory.errors import InputError
from compensator_theory.latex import diagonal, displayed, latex, unless
from compensator_theory.matrices.exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices.flint_matrices import is_rational_matrix, to_flint
from compensator_theory.matrices.flint_polynomials import from_flint_polynomial
from compensator_theory.polynomial_matrices.exceptional_factors import exceptional_factors
from compensator_theory.polynomial_matrices.polynomial_matrices import (
    PolynomialMatrix,
    polynomial_matrix,
)
from compensator_theory.polynomials.budget import ask
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.poly import canonical
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.polynomials.variables import as_symbol


@dataclass(frozen=True)
class KroneckerForm(ExactValue):
    r"""All that stays of a pencil sE - A under changes of both bases.

    Attributes
    ----------
    pencil : PolynomialMatrix
        sE - A, p x m.
    right_indices, left_indices : tuple of int
        Degrees of minimal bases of both null spaces: blocks :math:`L_\epsilon` of :math:`\epsilon
        \times (\epsilon + 1)` and :math:`L_\eta'`.
    invariant_polynomials : tuple of sympy.Poly
        Of the finite part, of degree 1 or more, each a divisor of the next.
    infinite_orders : tuple of int
        Sizes of the nilpotent blocks N_k at infinity, 1 or more.
    right_basis, left_basis : MinimalBasis
        With their certificates; the left one of the transposed pencil.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    """

    pencil: PolynomialMatrix
    right_indices: tuple[int, ...]
    left_indices: tuple[int, ...]
    invariant_polynomials: tuple[Poly, ...]
    infinite_orders: tuple[int, ...]
    right_basis: MinimalBasis
    left_basis: MinimalBasis
    exceptional: tuple[Expr, ...]

    @property
    def is_regular(self) -> bool:
        """Whether the pencil is square with det(sE - A) not zero for all s."""
        return not self.right_indices and not self.left_indices

    @property
    def finite_polynomial(self) -> Poly:
        """The product of the invariant polynomials; 1 if there are none."""
        one = Poly(1, self.pencil.variable, domain=sympy.QQ)
        return canonical(sympy.prod(self.invariant_polynomials, start=one))

    def __str__(self) -> str:
        finite = ", ".join(map(format_polynomial, self.invariant_polynomials)) or "none"
        return (
            f"right indices {self.right_indices}, left indices {self.left_indices}, finite "
            f"{finite}, infinite {self.infinite_orders}"
        )

    def _repr_latex_(self) -> str:
        s = self.pencil.variable
        blocks = [f"L_{{{index}}}" for index in self.right_indices]
        blocks += [f"L_{{{index}}}^T" for index in self.left_indices]
        blocks += [rf"{s} I - C_{{{latex(p)}}}" for p in self.invariant_polynomials]
        blocks += [rf"{s} N_{{{order}}} - I" for order in self.infinite_orders]
        form = diagonal(blocks) if blocks else "0"
        return displayed(rf"{latex(self.pencil)} \sim {form}", unless(self.exceptional))


def kronecker_form(A: MatrixLike, E: MatrixLike, variable: str | Symbol = "s") -> KroneckerForm:
    r"""Find Kronecker's invariants of a pencil.

    .. math:: sE - A \;\sim\; \mathrm{diag}(L_{\epsilon_1}, \ldots,\; L_{\eta_1}', \ldots,\;
              sI - J,\; sN - I)

    Parameters
    ----------
    A, E : matrix
        p x m each, of any shape; with symbols, for generic values of them.
    variable : str or Symbol

    Raises
    ------
    InputError, BudgetError
        If the shapes differ or are empty, or the matrices are too large.

    Notes
    -----
    The finite part is that of the Smith form of sE - A, the infinite one the powers of s in that of
    E - sA: for a regular pencil the form of Weierstrass. The sizes add up to the rank. With symbols
    both Smith forms are computed; where all numbers are rational, what is left between the
    subspaces of both minimal bases is one square matrix, and they are its elementary divisors.
    Source: L. Kronecker (1890); F. R. Gantmacher, The Theory of Matrices, vol. 2, XII; P. Van
    Dooren, Linear Algebra and its Applications 27 (1979).

    Examples
    --------
    >>> from compensator_theory import kronecker_form
    >>> print(kronecker_form([[0, 1, 0], [0, 0, 2]], [[1, 0, 0], [0, 0, 1]]))
    right indices (1,), left indices (), finite s - 2, infinite ()
    >>> print(kronecker_form([[1, 0], [0, 1]], [[0, 1], [0, 0]]))
    right indices (), left indices (), finite none, infinite (2,)
    """
    a, e, s = exact_matrix(A, "A"), exact_matrix(E, "E"), as_symbol(variable)
    if a.shape != e.shape or 0 in a.shape:
        raise InputError(
            f"A is {a.rows} x {a.cols} and E is {e.rows} x {e.cols}; both need one shape, with at "
            "least one row and one column"
        )
    if s in a.free_symbols | e.free_symbols:
        raise InputError(f"the matrices contain {s}, the variable; name another one")
    if is_rational_matrix(a) and is_rational_matrix(e):
        return _rational(to_flint(a), to_flint(e), s)
    pencil = polynomial_matrix(s * e - a, s)
    reverse = polynomial_matrix(e - s * a, s)
    right, left = minimal_basis(pencil), minimal_basis(pencil.T)
    finite, infinite = smith_form(pencil), smith_form(reverse)
    orders = []
    for invariant in infinite.invariant_polynomials:
        order = 0
        while invariant.coeff_monomial(s**order) == 0:
            order += 1
        orders.append(order)
    lowest = [
        p.coeff_monomial(s**k) for p, k in zip(infinite.invariant_polynomials, orders, strict=True)
    ]
    parts = (right, left, finite, infinite)
    return KroneckerForm(
        pencil,
        right.indices,
        left.indices,
        tuple(p for p in finite.invariant_polynomials if p.degree()),
        tuple(k for k in orders if k),
        right,
        left,
        exceptional_factors(
            [*(x for part in parts for x in part.exceptional), *map(sympy.sympify, lowest)]
        ),
    )


def _rational(A: flint.fmpq_mat, E: flint.fmpq_mat, s: Symbol) -> KroneckerForm:
    """Find the form without a Smith form, whose numbers would swell."""
    ask("degree", max(A.nrows(), A.ncols()), "the pencil")
    rows = [
        [from_flint_polynomial(flint.fmpq_poly([-a, e]), s) for a, e in zip(*row, strict=True)]
        for row in zip(A.tolist(), E.tolist(), strict=True)
    ]
    pencil = PolynomialMatrix(tuple(map(tuple, rows)))
    common = lcm(int(A.numer_denom()[1]), int(E.numer_denom()[1]))
    work = Pencil((A * common).numer_denom()[0], (E * common).numer_denom()[0])
    right, left = work.null_vectors(), work.T.null_vectors()
    finite, infinite = elementary_divisors(work, right, left)
    return KroneckerForm(
        pencil,
        tuple(len(vector) - 1 for vector in right),
        tuple(len(vector) - 1 for vector in left),
        tuple(from_flint_polynomial(p, s) for p in invariant_polynomials(finite)),
        tuple(sorted(infinite)),
        basis_of_pencil(pencil, right),
        basis_of_pencil(pencil.T, left),
        (),
    )
