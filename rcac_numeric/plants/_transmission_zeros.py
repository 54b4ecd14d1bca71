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
    By Kronecker's form of the Rosenbrock matrix as a pencil, of rational numbers. Source: the
    transmission zeros of section 3.4.1.

    Examples
    --------
    >>> from rcac_numeric import Plant, transmission_zero_polynomial
    >>> plant = Plant(A=[[0.5, 1.0], [0.0, 0.2]], B=[[0.0], [1.0]], D_1=[[0.0], [1.0]],
    ...               C=[[-2.0, 1.0]])
    >>> transmission_zero_polynomial(plant)
    Poly(q - 5/2, q, domain='QQ')
    """
    from sympy import Matrix, diag, eye, zeros

    from compensator_theory.forms import kronecker_form

    problem = linear_plant(plant).problem
    E_1, E_2 = Matrix(problem.E_1), Matrix(problem.E_2)
    upper = Matrix(problem.A).row_join(Matrix(problem.B))
    states = diag(eye(upper.rows), zeros(*E_2.shape))
    pencil = kronecker_form(upper.col_join(-E_1.row_join(E_2)), states, variable="q")
    return pencil.finite_polynomial.monic()


def rosenbrock_matrix(plant: Plant, weights: Matrix | None = None) -> Matrix:
    """The Rosenbrock matrix from u to z, or to weights z."""
    from sympy import Matrix, eye, symbols

    problem = plant.problem
    E_1, E_2 = Matrix(problem.E_1), Matrix(problem.E_2)
    if weights is not None:
        E_1, E_2 = weights * E_1, weights * E_2
    top = (symbols("q") * eye(plant.n) - Matrix(problem.A)).row_join(-Matrix(problem.B))
    return top.col_join(E_1.row_join(E_2))
