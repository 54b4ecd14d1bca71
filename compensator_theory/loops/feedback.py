"""The transfer function of a loop, from where a signal is added to the plant's input."""

from compensator_theory.loops.siso import LoopPart, read_loop, well_posed_loop
from compensator_theory.polynomials.poly import canonical
from compensator_theory.transfer_functions.sample_times import shared_sample_time
from compensator_theory.transfer_functions.transfer_functions import TransferFunction


def feedback_connection(
    plant: LoopPart, compensator: LoopPart, *, feedback: int
) -> TransferFunction:
    r"""Return the transfer function from v to y of y = G u, u = v + f G_c y, nothing cancelled.

    .. math:: \frac{G}{1 - f\,G\,G_c} = \frac{N D_c}{D D_c - f\,N N_c}

    Parameters
    ----------
    plant, compensator : transfer function
        N/D and :math:`N_c/D_c` in one variable; anything :func:`transfer_function` reads, symbols
        allowed.
    feedback : {+1, -1}
        The sign f.

    Returns
    -------
    TransferFunction
        Over the unreduced closed-loop polynomial, so that a mode which the loop hides is there.

    Raises
    ------
    ImproperError
        If the loop is not well posed.
    InputError
        If the variables differ or `feedback` is neither +1 nor -1.

    Notes
    -----
    Source: the loop of (2.9) with f = +1, of (7.22) with f = -1.

    Examples
    --------
    >>> from compensator_theory import feedback_connection
    >>> print(feedback_connection("1/(s - 1)", "k*(s + 2)/(s + 3)", feedback=-1))
    (s + 3)/(s**2 + (k + 2)*s + (2*k - 3))
    """
    G, G_c = read_loop(plant, compensator, feedback)
    closed = well_posed_loop(G, G_c, feedback)
    numerator, period = canonical(G.numerator * G_c.denominator), shared_sample_time(G, G_c)
    return TransferFunction(numerator, closed, sample_time=period)
