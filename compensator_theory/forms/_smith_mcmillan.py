"""The Smith-McMillan form of a transfer matrix: its poles and zeros with multiplicity."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import diagonal, displayed, fraction, unless
from compensator_theory.forms._equivalence import Equivalence
from compensator_theory.forms._polynomial_matrices import PolynomialMatrix
from compensator_theory.forms._smith import smith_form
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import zero_matrix
from compensator_theory.matrices._rings import in_lowest_terms, resultant_of_monic
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.roots._certified import Root, certified_roots
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._transfer_matrices import TransferMatrix


@dataclass(frozen=True)
class SmithMcMillanForm(ExactValue):
    r"""The diagonal form of a transfer matrix under unimodular row and column operations.

    .. math:: U G V = \mathrm{diag}\!\left(\frac{\varepsilon_1}{\psi_1}, \ldots,
              \frac{\varepsilon_r}{\psi_r}, 0, \ldots\right), \qquad
              \varepsilon_i \mid \varepsilon_{i+1}, \quad \psi_{i+1} \mid \psi_i

    Attributes
    ----------
    numerators, denominators : tuple of sympy.Poly
        The zero polynomials epsilon_i and pole polynomials psi_i, monic, coprime in pairs.
    orders_at_infinity : tuple of int
        Ascending: -k for a pole of order k at infinity, k for a zero of order k there.
    smith : Equivalence
        Of the numerators over the common denominator, with U, V and the certificate.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the form holds where none of them is zero.
    """

    numerators: tuple[Poly, ...]
    denominators: tuple[Poly, ...]
    orders_at_infinity: tuple[int, ...]
    smith: Equivalence
    exceptional: tuple[Expr, ...]

    @property
    def rank(self) -> int:
        """The normal rank r."""
        return self.smith.rank

    @property
    def certificate(self) -> Certificate:
        """The certificate of the Smith form."""
        return self.smith.certificate

    @property
    def pole_polynomial(self) -> Poly:
        """The product of the psi_i: the finite poles with multiplicity."""
        return self._product(self.denominators)

    @property
    def zero_polynomial(self) -> Poly:
        """The product of the epsilon_i: the finite transmission zeros with multiplicity."""
        return self._product(self.numerators)

    @property
    def mcmillan_degree(self) -> int:
        """Number of poles, those at infinity included."""
        at_infinity = sum(-order for order in self.orders_at_infinity if order < 0)
        return int(self.pole_polynomial.degree()) + at_infinity

    @property
    def poles(self) -> tuple[Root, ...]:
        """The certified finite poles with multiplicity; InputError with symbols."""
        return certified_roots(self.pole_polynomial)

    @property
    def zeros(self) -> tuple[Root, ...]:
        """The certified finite zeros with multiplicity; InputError with symbols."""
        return certified_roots(self.zero_polynomial)

    def _product(self, factors: tuple[Poly, ...]) -> Poly:
        one = Poly(1, self.smith.matrix.variable, domain=sympy.QQ)
        return canonical(sympy.prod(factors, start=one))

    def __str__(self) -> str:
        pairs = zip(self.numerators, self.denominators, strict=True)
        parts = [f"({format_polynomial(e)})/({format_polynomial(p)})" for e, p in pairs]
        return f"diag({', '.join(parts)})"

    def _repr_latex_(self) -> str:
        pairs = zip(self.numerators, self.denominators, strict=True)
        form = diagonal(fraction(top, below) for top, below in pairs) if self.rank else "0"
        return displayed(f"U G V = {form}", unless(self.exceptional))


@carrying()
def smith_mcmillan_form(
    G: TransferMatrixLike, variable: str | Symbol | None = None
) -> SmithMcMillanForm:
    r"""Bring a transfer matrix to its Smith-McMillan form, at infinity too.

    .. math:: G = \frac ND, \qquad \frac{\varepsilon_i}{\psi_i} = \frac{\lambda_i(N)}{D}
              \text{ in lowest terms}

    Parameters
    ----------
    G : transfer matrix
        Anything :func:`transfer_matrix` reads, of any shape, improper ones too.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Raises
    ------
    InputError, BudgetError
        If it cannot be read, or is too large.

    Notes
    -----
    The structure at infinity is that of G(1/w) at w = 0. Source: B. McMillan (1952); T. Kailath,
    Linear Systems (1980), Sections 6.5.2 and 6.5.3; at infinity P. Van Dooren, P. Dewilde and
    J. Vandewalle, IEEE Transactions on Circuits and Systems 26 (1979).

    Examples
    --------
    >>> from compensator_theory.forms import smith_mcmillan_form
    >>> G = [["s/((s + 1)**2*(s + 2)**2)", "s/(s + 2)**2"], ["-s/(s + 1)**2", "-s/(s + 1)**2"]]
    >>> form = smith_mcmillan_form(G)
    >>> print(form, form.mcmillan_degree)
    diag((s)/(s**4 + 6*s**3 + 13*s**2 + 12*s + 4), (s**3 + 2*s**2)/(s**2 + 2*s + 1)) 6
    """
    source = transfer_matrix(G, variable)
    bottom = source.denominator
    smith = smith_form(PolynomialMatrix(source.numerators))
    numerators, denominators, divisors = [], [], []
    for invariant in smith.invariant_polynomials:
        top, below = in_lowest_terms(invariant, bottom)
        numerators.append(top)
        denominators.append(below)
        divisors.append(resultant_of_monic(top, below))
    at_infinity, more = _at_infinity(source, smith.rank) if smith.rank else ((), [])
    return SmithMcMillanForm(
        tuple(numerators),
        tuple(denominators),
        at_infinity,
        smith,
        exceptional_factors([*smith.exceptional, *divisors, *more]),
    )


def _at_infinity(G: TransferMatrix, rank: int) -> tuple[tuple[int, ...], list[Expr]]:
    """Return the orders at w = 0 of G(1/w), by ranks of block Toeplitz matrices.

    Each block that is added to the matrix raises its rank by the number of invariant polynomials
    of N(1/w) w**h whose order at 0 is smaller than the number of blocks.
    """
    s, height = G.variable, max(int(e.degree()) for row in G.numerators for e in row if e)
    blocks: list[ImmutableMatrix] = []
    orders: list[int] = []
    divisors, before, known_rank = [], 0, 0
    while known_rank < rank:
        k = len(blocks)
        power = s ** (height - k)
        blocks.append(
            ImmutableMatrix([
                [entry.coeff_monomial(power) if k <= height else 0 for entry in row]
                for row in G.numerators
            ])
        )  # fmt: skip
        toeplitz = echelon(_toeplitz(blocks))
        divisors.append(toeplitz.divided_by)
        grown = len(toeplitz.pivots) - before
        orders += [k + int(G.denominator.degree()) - height] * (grown - known_rank)
        before, known_rank = len(toeplitz.pivots), grown
    return tuple(orders), divisors


def _toeplitz(blocks: list[ImmutableMatrix]) -> ImmutableMatrix:
    zero = zero_matrix(*blocks[0].shape)
    size = len(blocks)
    return ImmutableMatrix.vstack(
        *(
            ImmutableMatrix.hstack(*(blocks[i - j] if j <= i else zero for j in range(size)))
            for i in range(size)
        )
    )
