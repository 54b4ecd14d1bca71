"""The closed loop of two realisations as one matrix."""

from __future__ import annotations

import sympy
from sympy import ImmutableMatrix

from compensator_theory.errors import InputError
from compensator_theory.loops.siso import agreed_sign
from compensator_theory.polynomials.budget import shown
from compensator_theory.systems.realisations import Realisation


def closed_loop_matrix(
    plant: Realisation, compensator: Realisation, *, feedback: int | None = None
) -> ImmutableMatrix:
    r"""Return the dynamics matrix of plant and compensator.

    .. math:: \tilde A = \begin{bmatrix} A & B C_c \\ B_c C & A_c + B_c D_0 C_c \end{bmatrix}

    Parameters
    ----------
    plant : Realisation
        (A, B, C, D_0) with n states.
    compensator : Realisation
        :math:`(A_c, B_c, C_c)`, strictly proper, with :math:`n_c` states.
    feedback : {+1, -1}, optional
        The sign f in :math:`u = f C_c x_c`; default +1, as in the matrix above.

    Returns
    -------
    sympy.ImmutableMatrix
        Square, of size :math:`n + n_c`.

    Raises
    ------
    InputError
        If the numbers of signals or the variables differ, the compensator has a direct term, or was
        designed for the other sign.

    Notes
    -----
    Source: (7.14), where :math:`D_0 = 0`. A direct term d of the compensator can be counted as
    part of the plant: with :math:`u = C_c x_c + dy` and :math:`D_0 = 0` the loop is that of
    :math:`(A + BdC, B, C)` and :math:`(A_c, B_c, C_c)`.

    Examples
    --------
    >>> from compensator_theory import Realisation, closed_loop_matrix
    >>> closed_loop_matrix(Realisation([[1]], [[1]], [[2]]), Realisation([[-3]], [[4]], [[5]]))
    Matrix([
    [1,  5],
    [8, -3]])
    """
    for value in (plant, compensator):
        if not isinstance(value, Realisation):
            raise InputError(f"{shown(value)} is not a Realisation; make one with realisation(...)")
    if compensator.variable != plant.variable:
        raise InputError(
            f"the plant is written in {plant.variable} and the compensator in "
            f"{compensator.variable}; they need the same variable"
        )
    if compensator.D.shape != plant.D.T.shape:
        raise InputError(
            f"the compensator maps {compensator.B.cols} to {compensator.C.rows} signals, but the "
            f"plant has {plant.C.rows} outputs and {plant.B.cols} inputs"
        )
    if not compensator.is_strictly_proper:
        raise InputError(
            f"the compensator has the direct term {compensator.D.tolist()}, which a state estimate "
            "does not produce; count it as part of the plant, (A + BdC, B, C), and give the rest"
        )
    compensator = compensator.with_sign(agreed_sign(compensator, feedback))
    inner = compensator.A + compensator.B * plant.D * compensator.C
    return ImmutableMatrix(
        sympy.Matrix.vstack(
            plant.A.row_join(plant.B * compensator.C), (compensator.B * plant.C).row_join(inner)
        )
    )
