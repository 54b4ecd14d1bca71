"""The closed loop of two realisations as one matrix."""

from __future__ import annotations

from sympy import ImmutableMatrix, Symbol

from compensator_theory.errors import InputError
from compensator_theory.loops._siso import agreed_sign
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._sample_times import shared_sample_time


@holds_where_defined
@carrying()
def closed_loop_matrix(
    plant: RealisationLike,
    compensator: RealisationLike,
    *,
    feedback: int | None = None,
    variable: str | Symbol | None = None,
) -> ImmutableMatrix:
    r"""Return the dynamics matrix of plant and compensator.

    .. math:: \tilde A = \begin{bmatrix} A & B C_c \\ B_c C & A_c + B_c D_0 C_c \end{bmatrix}

    Parameters
    ----------
    plant : Realisation, (A, B, C, D_0), or input of :func:`realisation`
        With n states.
    compensator : Realisation, (A_c, B_c, C_c), or input of :func:`realisation`
        Strictly proper, with :math:`n_c` states.
    feedback : {+1, -1}, optional
        The sign f in :math:`u = f C_c x_c`; default +1, as in the matrix above.
    variable : str or Symbol, optional
        As for :func:`realisation`.

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
    G = realisation(plant, variable)
    G_c = realisation(compensator, variable)
    if G_c.variable != G.variable:
        raise InputError(
            f"the plant is written in {G.variable} and the compensator in {G_c.variable}; they "
            "need the same variable"
        )
    shared_sample_time(G, G_c)
    if G_c.D.shape != G.D.T.shape:
        raise InputError(
            f"the compensator maps {G_c.B.cols} to {G_c.C.rows} signals, but the plant has "
            f"{G.C.rows} outputs and {G.B.cols} inputs"
        )
    if not G_c.is_strictly_proper:
        raise InputError(
            f"the compensator has the direct term {G_c.D.tolist()}, which a state estimate does "
            "not produce; count it as part of the plant, (A + BdC, B, C), and give the rest"
        )
    G_c = G_c.with_sign(agreed_sign(G_c, feedback))
    inner = G_c.A + G_c.B * G.D * G_c.C
    above, below = G.A.row_join(G.B * G_c.C), (G_c.B * G.C).row_join(inner)
    return ImmutableMatrix(above.col_join(below))
