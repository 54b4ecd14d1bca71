"""Invariant subspaces of an exact matrix, one primary component at a time."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import sympy
from sympy import ImmutableMatrix, Matrix, Poly
from sympy.polys.matrices import DomainMatrix

from compensator_theory.matrices._linear_algebra import rank, solve_affine
from compensator_theory.polynomials._poly import canonical, monic
from compensator_theory.polynomials._values import ExactValue


@dataclass(frozen=True)
class PrimaryComponent(ExactValue):
    r"""The primary component of a matrix for one irreducible factor f of its polynomial.

    .. math:: \ker f(\tilde A) \subseteq \ker f(\tilde A)^2 \subseteq \cdots
              \subseteq \ker f(\tilde A)^m

    Attributes
    ----------
    factor : sympy.Poly
        Monic, irreducible over the rationals.
    multiplicity : int
        Its exponent m in the characteristic polynomial.
    kernels : tuple of sympy.ImmutableMatrix
        Bases of the kernels of the powers 0, 1, ..., m, as columns.
    """

    factor: Poly
    multiplicity: int
    kernels: tuple[ImmutableMatrix, ...]

    @property
    def degree(self) -> int:
        """Degree of the irreducible factor."""
        return int(self.factor.degree())

    @property
    def is_derogatory(self) -> bool:
        """Whether there are several Jordan blocks, and so a continuum of invariant subspaces."""
        return bool(self.kernels[1].cols > self.degree)

    @property
    def block_lengths(self) -> tuple[int, ...]:
        """Lengths of the Jordan blocks, longest first."""
        steps = itertools.pairwise(kernel.cols for kernel in self.kernels)
        blocks_at_least = [(high - low) // self.degree for low, high in steps]
        longest_first = range(blocks_at_least[0])
        return tuple(sum(count > i for count in blocks_at_least) for i in longest_first)

    def has_continuum(self, exponent: int) -> bool:
        r"""Tell whether several invariant subspaces have the polynomial :math:`f^e`."""
        return bool(self.kernels[exponent].cols > exponent * self.degree)


def primary_components(matrix: Matrix, polynomial: Poly) -> tuple[PrimaryComponent, ...]:
    """Split a matrix along the irreducible factors of its characteristic polynomial."""
    components = []
    for factor, multiplicity in polynomial.factor_list()[1]:
        f = monic(canonical(factor))
        value = DomainMatrix.from_Matrix(evaluate(f, matrix))
        power, kernels = value, [ImmutableMatrix(matrix.rows, 0, [])]
        for _ in range(multiplicity):
            kernels.append(kernel(power.to_Matrix()))
            power = power * value
        components.append(PrimaryComponent(f, multiplicity, tuple(kernels)))
    return tuple(components)


def divisors(
    components: Sequence[PrimaryComponent], degree: int
) -> Iterator[tuple[tuple[int, ...], Poly]]:
    """Yield exponents and product of every rational monic divisor of that degree."""
    for exponents in _exponents([(c.degree, c.multiplicity) for c in components], degree):
        product = Poly(1, components[0].factor.gen) if components else None
        for component, exponent in zip(components, exponents, strict=True):
            product = product * component.factor**exponent
        yield exponents, canonical(product)


def derogatory_factor(matrix: Matrix, polynomial: Poly) -> Poly | None:
    """Return an irreducible factor with several Jordan blocks, or None if there is none."""
    for factor, multiplicity in polynomial.factor_list()[1]:
        if multiplicity > 1:
            f = monic(canonical(factor))
            if matrix.rows - rank(evaluate(f, matrix)) > f.degree():
                return f
    return None


def evaluate(poly: Poly, matrix: Matrix) -> ImmutableMatrix:
    """Return p(A), by Horner's rule."""
    coefficients = Matrix([poly.all_coeffs()])
    a, c = DomainMatrix.from_Matrix(matrix).unify(
        DomainMatrix.from_Matrix(coefficients), fmt="dense"
    )
    identity = DomainMatrix.eye(matrix.rows, a.domain).to_dense()
    result = identity * a.domain.zero
    for coefficient in c.to_list()[0]:
        result = result * a + identity * coefficient
    return ImmutableMatrix(result.to_Matrix())


def kernel(matrix: Matrix) -> ImmutableMatrix:
    """Return a basis of the right kernel as columns, without a column if it is trivial."""
    basis = solve_affine(matrix, sympy.zeros(matrix.rows, 1)).nullspace
    return joined(matrix.cols, basis)


def joined(rows: int, blocks: Sequence[Matrix]) -> ImmutableMatrix:
    """Put blocks with the same number of rows side by side; none gives a matrix without columns."""
    return ImmutableMatrix(sympy.Matrix.hstack(sympy.zeros(rows, 0), *blocks))


def _exponents(sizes: Sequence[tuple[int, int]], degree: int) -> Iterator[tuple[int, ...]]:
    if not sizes:
        if degree == 0:
            yield ()
        return
    (size, multiplicity), rest = sizes[0], sizes[1:]
    if degree > sum(d * m for d, m in sizes):
        return
    for exponent in range(min(multiplicity, degree // size) + 1):
        for others in _exponents(rest, degree - size * exponent):
            yield (exponent, *others)
