"""Transmission zeros of G_zu for any numbers of signals, exactly."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant

if TYPE_CHECKING:
    from sympy import Matrix, Poly


def transmission_zero_polynomial(plant: Plant) -> Poly:
    """The monic polynomial whose roots are the invariant zeros of (A, B, E_1, E_2).

    They are the numbers at which the Rosenbrock matrix

    [ qI - A   -B ]
    [  E_1    E_2 ]

    loses rank, with multiplicity: the roots of the product of its invariant factors. For a
    minimal realisation these are the transmission zeros of G_zu; a hidden mode of A counts too,
    and an unstable one limits a controller as an NMP zero does. A tall G_zu usually has none.

    Parameters
    ----------
    plant : Plant, or a system that `plant_of` reads
        Any numbers of signals; its entries mean their shortest decimals.

    Returns
    -------
    sympy.Poly
        In q; 1 where there are no zeros.

    Notes
    -----
    By the Smith form over the rationals, whose coefficients grow quickly: plants of up to about
    ten states. Source: the transmission zeros of section 3.4.1.

    Examples
    --------
    >>> from rcac_numeric import Plant, transmission_zero_polynomial
    >>> plant = Plant(A=[[0.5, 1.0], [0.0, 0.2]], B=[[0.0], [1.0]], D_1=[[0.0], [1.0]],
    ...               C=[[-2.0, 1.0]])
    >>> transmission_zero_polynomial(plant)
    Poly(q - 5/2, q, domain='QQ')
    """
    from sympy import QQ, Poly, symbols
    from sympy.polys.matrices import DomainMatrix
    from sympy.polys.matrices.normalforms import invariant_factors

    plant, q = linear_plant(plant), symbols("q")
    pencil = DomainMatrix.from_Matrix(rosenbrock_matrix(plant)).convert_to(QQ[q])
    product = Poly(1, q, domain=QQ)
    for factor in invariant_factors(pencil):
        if factor:
            product *= Poly(pencil.domain.to_sympy(factor), q, domain=QQ).monic()
    return product


def rosenbrock_matrix(plant: Plant, weights: Matrix | None = None) -> Matrix:
    """The Rosenbrock matrix from u to z, or to weights z."""
    from sympy import Matrix, eye, symbols

    problem = plant.problem
    E_1, E_2 = Matrix(problem.E_1), Matrix(problem.E_2)
    if weights is not None:
        E_1, E_2 = weights * E_1, weights * E_2
    top = (symbols("q") * eye(plant.n) - Matrix(problem.A)).row_join(-Matrix(problem.B))
    return top.col_join(E_1.row_join(E_2))
