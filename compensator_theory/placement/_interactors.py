"""The interactor of a transfer matrix: its delays as a unique triangular polynomial matrix."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory._printing import text
from compensator_theory.errors import ImproperError, NoSolutionError
from compensator_theory.forms._polynomial_matrices import PolynomialMatrix
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import zero_matrix
from compensator_theory.matrices._linear_algebra import rank
from compensator_theory.placement._subspaces import Subspaces
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._transfer_matrices import TransferMatrix

IDENTITY = "the coefficients of xi N above deg D are zero, those at it are the limit"


@dataclass(frozen=True)
class Interactor(ExactValue):
    r"""The least polynomial matrix whose product with a transfer matrix has an invertible limit.

    Attributes
    ----------
    matrix : PolynomialMatrix
        :math:`\xi = H\,\mathrm{diag}(s^{f_1}, \ldots, s^{f_p})`, where H is lower triangular with
        ones on its diagonal and multiples of s below.
    limit : sympy.ImmutableMatrix
        p x m, of rank p: :math:`\lim_{s \to \infty} \xi G`.
    powers : tuple of int
        The f_i; their sum is the degree of det(xi), the number of zeros at infinity.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    certificate : Certificate
        The product with G, multiplied out anew.
    """

    matrix: PolynomialMatrix
    limit: ImmutableMatrix
    powers: tuple[int, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def __str__(self) -> str:
        return f"{self.matrix}, limit {text(self.limit.tolist())}"

    def _repr_latex_(self) -> str:
        s = latex(self.matrix.variable)
        limit = rf"\lim_{{{s} \to \infty}} \xi G = {latex(self.limit)}"
        return displayed(rf"\xi = {latex(self.matrix)}", limit, unless(self.exceptional))


@carrying()
def interactor(G: TransferMatrixLike, variable: str | Symbol | None = None) -> Interactor:
    r"""Find the interactor of a proper transfer matrix: the delay of each combination of outputs.

    It is diagonal if and only if static state feedback decouples a square plant: :func:`decouple`.

    .. math:: \lim_{s \to \infty} \xi(s)\,G(s) = K, \qquad \mathrm{rank}\,K = p

    Parameters
    ----------
    G : transfer matrix
        p x m, p <= m, proper; anything :func:`transfer_matrix` reads. With symbols, for generic
        values of them.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Returns
    -------
    Interactor
        Unique. In discrete time it gives the delays of combinations of outputs in steps: a
        target model needs the same.

    Raises
    ------
    NoSolutionError
        If the rows of G are dependent.
    ImproperError, InputError, BudgetError
        If G is improper, cannot be read, or is too large.

    See Also
    --------
    decouple : The feedback that decouples, and the poles that it leaves hidden.

    Notes
    -----
    Source: W. A. Wolovich, P. L. Falb, SIAM J. Control and Optimization 14 (1976) 996-1008.

    Examples
    --------
    >>> from compensator_theory.geometry import interactor
    >>> print(interactor([["1/(s + 1)", "1/(s + 2)"], ["1/(s + 3)", "1/(s + 4)"]]))
    [[s, 0], [-s**3 + 2*s**2, s**3]], limit [[1, 1], [6, 8]]
    """
    source = transfer_matrix(G, variable)
    s, size = source.variable, int(source.denominator.degree())
    ask("degree", source.shape[0] * (size + 1), "the interactor")
    highest = max(
        (int(e.degree()) for r in source.numerators for e in r if not e.is_zero), default=0
    )
    if highest > size:
        raise ImproperError(f"the transfer matrix has an entry of degree {highest} over {size}")
    if rank(source.numerator_matrix()) < source.shape[0]:
        raise NoSolutionError(
            f"the {source.shape[0]} rows of the transfer matrix are dependent over the rational "
            "functions: one is a combination of the others; leave such an output out"
        )
    work = Subspaces()
    done: list[tuple[list[Poly], list[Poly]]] = []
    limits = zero_matrix(0, source.shape[1])
    powers: list[int] = []
    for i, start in enumerate(source.numerators):
        product = list(start)
        row = [Poly(int(i == j), s, domain=sympy.QQ) for j in range(source.shape[0])]
        power = 0
        while True:
            step = size - max(int(entry.degree()) for entry in product if not entry.is_zero)
            power += step
            shift = Poly(s**step, s)
            product = [canonical(entry * shift) for entry in product]
            row = [canonical(entry * shift) for entry in row]
            limit = ImmutableMatrix([[entry.coeff_monomial(s**size) for entry in product]])
            work.divisors += [_first(limit)]
            weights = work.coordinates(limits.T, limit.T)
            if weights is None:
                break
            for weight, (other, multiplier) in zip(weights, done, strict=True):
                product = [canonical(a - b * weight) for a, b in zip(product, other, strict=True)]
                row = [canonical(a - b * weight) for a, b in zip(row, multiplier, strict=True)]
        done.append((product, row))
        limits = limits.col_join(limit)
        powers.append(power)
    matrix = PolynomialMatrix(tuple(tuple(row) for _, row in done))
    return Interactor(
        matrix,
        limits,
        tuple(powers),
        exceptional_factors(work.divisors),
        _certificate(matrix, source, limits, size),
    )


def _first(limit: ImmutableMatrix) -> Expr:
    """Return an entry with a nonzero leading coefficient, a number if there is one."""
    nonzero = [entry for entry in limit if entry != 0]
    return min(nonzero, key=lambda entry: len(entry.free_symbols))


def _certificate(
    matrix: PolynomialMatrix, G: TransferMatrix, limit: ImmutableMatrix, size: int
) -> Certificate:
    product = matrix @ PolynomialMatrix(G.numerators)
    s = G.variable
    left = [
        product.rows[i][j].coeff_monomial(s**size) - limit[i, j]
        for i in range(limit.rows)
        for j in range(limit.cols)
    ]
    above = [
        entry.coeff_monomial(s**k)
        for row in product.rows
        for entry in row
        if not entry.is_zero
        for k in range(size + 1, int(entry.degree()) + 1)
    ]
    return certificate_of(IDENTITY, [ImmutableMatrix(1, len(left + above), left + above)])
