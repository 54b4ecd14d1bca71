"""The transfer function of a loop from an input added to the control."""

from __future__ import annotations

from typing import TypeAlias, overload

from sympy import MatrixBase, Symbol

from compensator_theory.errors import BudgetError, ImproperError, InputError
from compensator_theory.loops._siso import (
    LoopPart,
    in_variable_of,
    read_loop,
    require_sign,
    well_posed_loop,
)
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._poly import canonical, over_one_field
from compensator_theory.systems._descriptions import shape_of
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._sample_times import shared_sample_time
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix

SeveralSignals: TypeAlias = TransferMatrix | MatrixBase
"""Types that identify a loop of matrices."""


@overload
def feedback_connection(
    plant: SeveralSignals,
    compensator: TransferMatrixLike | Realisation,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> TransferMatrix: ...
@overload
def feedback_connection(
    plant: LoopPart,
    compensator: SeveralSignals,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> TransferMatrix: ...
@overload
def feedback_connection(
    plant: LoopPart, compensator: LoopPart, *, feedback: int, variable: str | Symbol | None = None
) -> TransferFunction: ...
@holds_where_defined
@carrying()
def feedback_connection(
    plant: LoopPart | TransferMatrixLike,
    compensator: LoopPart | TransferMatrixLike,
    *,
    feedback: int,
    variable: str | Symbol | None = None,
) -> TransferFunction | TransferMatrix:
    r"""Return the transfer function from v to y of y = G u, u = v + f G_c y.

    .. math:: \frac{G}{1 - f\,G\,G_c} = \frac{N D_c}{D D_c - f\,N N_c}, \qquad
              (I - f\,G\,G_c)^{-1}\,G

    Parameters
    ----------
    plant, compensator : transfer function, or transfer matrix
        N/D and :math:`N_c/D_c` in one variable; anything :func:`transfer_function` reads, symbols
        allowed. Where one of the two is a :class:`TransferMatrix`, a matrix of SymPy, or has
        several signals, in rows for instance, the other is read as a matrix too.
    feedback : {+1, -1}
        The sign f.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    TransferFunction
        Over the unreduced closed-loop polynomial, so that a mode which the loop hides is there.
    TransferMatrix
        Of matrices, reduced: hidden modes are absent. ``Realisation.feedback_with``
        keeps every state.

    Raises
    ------
    ImproperError
        If the loop is not well posed.
    InputError
        If the variables or the signals do not fit, or `feedback` is neither +1 nor -1.

    Notes
    -----
    Source: the loop of (2.9) with f = +1, of (7.22) with f = -1.

    Examples
    --------
    >>> from compensator_theory import feedback_connection, transfer_matrix
    >>> print(feedback_connection("1/(s - 1)", "k*(s + 2)/(s + 3)", feedback=-1))
    (s + 3)/(s**2 + (k + 2)*s + (2*k - 3))
    >>> G = transfer_matrix([["1/(s + 1)", "1/s"], [0, "1/(s + 2)"]])
    >>> closed_loop = feedback_connection(G, [["k", 0], [0, "k"]], feedback=-1)
    >>> print(closed_loop.denominator.as_expr().factor())
    s*(k + s + 1)*(k + s + 2)
    """
    if any(_is_matrix(part, variable) for part in (plant, compensator)):
        return _of_matrices(plant, compensator, feedback, variable)
    G, G_c = read_loop(plant, compensator, feedback, variable=variable)
    closed = well_posed_loop(G, G_c, feedback)
    N, D_c = over_one_field(G.numerator, G_c.denominator)
    return TransferFunction(canonical(N * D_c), closed, sample_time=shared_sample_time(G, G_c))


def _is_matrix(part: LoopPart | TransferMatrixLike, variable: str | Symbol | None) -> bool:
    return isinstance(part, SeveralSignals) or shape_of(part, variable) != (1, 1)


def _of_matrices(
    plant: TransferMatrixLike,
    compensator: TransferMatrixLike,
    feedback: int,
    variable: str | Symbol | None,
) -> TransferMatrix:
    require_sign(feedback)
    G = transfer_matrix(plant, variable)
    G_c = in_variable_of(G, compensator, transfer_matrix)
    if G_c.variable != G.variable:
        raise InputError(
            f"the plant is written in the variable {G.variable} and the compensator in "
            f"{G_c.variable}; they need the same variable"
        )
    outputs, inputs = G.shape
    if G_c.shape != (inputs, outputs):
        raise InputError(
            f"a compensator of {G_c.shape} signals (outputs, inputs) does not fit a plant of "
            f"{G.shape}; it needs {(inputs, outputs)}"
        )
    difference: TransferMatrix = -feedback * (G @ G_c) + identity_matrix(outputs)
    try:
        sensitivity = difference.inverse()
    except BudgetError:
        raise
    except InputError:
        raise ImproperError("the loop is not well posed: det(I - f G G_c) = 0") from None
    if not all(sensitivity[i, j].is_proper for i in range(outputs) for j in range(outputs)):
        raise ImproperError(
            "the loop is not well posed: det(I - f G G_c) tends to 0 at infinity, so that the "
            "direct terms cancel"
        )
    return (sensitivity @ G).reduced()
