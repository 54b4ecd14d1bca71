"""Matrices over one domain of SymPy, which decides whether an entry is zero."""

from __future__ import annotations

from sympy import Matrix
from sympy.polys.constructor import construct_domain
from sympy.polys.domains.domainelement import DomainElement
from sympy.polys.matrices import DomainMatrix


def domain_matrices(*matrices: Matrix) -> list[DomainMatrix]:
    """Return dense matrices over the least domain that holds the entries of all of them.

    Algebraic numbers make a number field, of all of them together; SymPy's own reading leaves them
    unrelated expressions, of which no elimination knows the zeros. In sparse form it keeps an entry
    such as (1 - b)/b + (b - 1)/b as a nonzero one.
    """
    flat = [entry for matrix in matrices for entry in matrix]
    domain, values = construct_domain(flat, extension=True)
    left = iter(values)
    return [
        DomainMatrix(
            [[next(left) for _ in range(matrix.cols)] for _ in range(matrix.rows)],
            matrix.shape,
            domain,
        ).to_dense()
        for matrix in matrices
    ]


def divided_by(matrix: DomainMatrix, divisor: DomainElement) -> DomainMatrix:
    """Divide a matrix by an element of its domain, over the field of the domain."""
    ring, field = matrix.domain, matrix.domain.get_field()
    element = divisor if field == ring else field.convert_from(divisor, ring)
    return matrix.convert_to(field) * (field.one / element)
