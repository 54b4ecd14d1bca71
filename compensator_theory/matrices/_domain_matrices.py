"""Matrices over one domain of SymPy, which decides what is zero in it."""

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

    Examples
    --------
    >>> from sympy import Matrix, sqrt
    >>> from compensator_theory.matrices._domain_matrices import domain_matrices
    >>> (found,) = domain_matrices(Matrix([[sqrt(2) + sqrt(3), sqrt(5 + 2 * sqrt(6))], [1, 1]]))
    >>> found.rank()
    1
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
    """Divide a matrix by an element of its domain, over the field of the domain.

    Examples
    --------
    >>> from sympy import Matrix, sqrt
    >>> from compensator_theory.matrices._domain_matrices import divided_by, domain_matrices
    >>> (found,) = domain_matrices(Matrix([[sqrt(2), 2]]))
    >>> divided_by(found, found[0, 0].element).to_Matrix()
    Matrix([[1, sqrt(2)]])
    """
    ring, field = matrix.domain, matrix.domain.get_field()
    element = divisor if field == ring else field.convert_from(divisor, ring)
    return matrix.convert_to(field) * (field.one / element)
