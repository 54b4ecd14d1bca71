"""The adjugate and the determinant of a matrix over a ring, without divisions."""

from __future__ import annotations

from sympy.polys.domains.domainelement import DomainElement
from sympy.polys.matrices import DomainMatrix


def adjugate_and_determinant(matrix: DomainMatrix) -> tuple[DomainMatrix, DomainElement]:
    r"""Return the adjugate and the determinant, from the characteristic polynomial.

    .. math:: \mathrm{adj}\,A = (-1)^{n-1}(A^{n-1} + c_1 A^{n-2} + \cdots + c_{n-1} I)

    SymPy's ``adj_det`` (1.14) fails where one of the coefficients is 0, of [[0, 1], [s, 0]] for
    instance.
    """
    n, domain = matrix.shape[0], matrix.domain
    coefficients = matrix.charpoly()
    identity = DomainMatrix.eye(n, domain).convert_to(domain)
    dense, one = matrix.to_dense(), identity.to_dense()
    total = one
    for c in coefficients[1:n]:
        total = dense * total + one.scalarmul(c)
    last = coefficients[n] if n else domain.one
    if n % 2:
        return total, -last
    return -total, last
