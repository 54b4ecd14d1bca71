"""Closed-loop maps of the standard problem, with exactly the poles that the loop has."""

from __future__ import annotations

from sympy import Poly

from compensator_theory.errors import InputError
from compensator_theory.loops._loop import PolynomialMatrixLike, close_loop, require_problem
from compensator_theory.polynomials._budget import repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._reading import is_one_of
from compensator_theory.systems._standard_problems import StandardProblem
from compensator_theory.systems._transfer_matrices import TransferMatrix


@holds_where_defined
@carrying()
def closed_loop_polynomial(
    problem: StandardProblem, N_c: PolynomialMatrixLike, D_c: PolynomialMatrixLike
) -> Poly:
    r"""Return the closed-loop characteristic polynomial with positive feedback.

    .. math:: \tilde D = D D_c - N_{yu} N_c, \qquad
              \tilde D = \det(D D_c - N_c N_{yu})/D^{l_u-1} \text{ for matrices}

    Parameters
    ----------
    problem, N_c, D_c
        See :func:`~compensator_theory.loops._loop.close_loop`.

    Returns
    -------
    sympy.Poly
        Of degree :math:`n + l_u n_c`; monic unless compensator and plant both have direct terms.

    Raises
    ------
    InputError, ImproperError
        See :func:`~compensator_theory.loops._loop.close_loop`.

    Notes
    -----
    Source: the denominator of (2.13), (2.14), (4.18), free of the extra factor D of (2.11).

    Examples
    --------
    >>> from compensator_theory import closed_loop_polynomial, standard_problem
    >>> closed_loop_polynomial(standard_problem("1/(q - 2)"), "-2", "q")
    Poly(q**2 - 2*q + 2, q, domain='QQ')
    """
    return close_loop(problem, N_c, D_c).characteristic_polynomial()


@carrying()
def closed_loop_transfer_matrix(
    problem: StandardProblem, N_c: PolynomialMatrixLike, D_c: PolynomialMatrixLike
) -> TransferMatrix:
    r"""Return the closed-loop map from w to z with positive feedback.

    .. math:: \tilde G_{zw} = G_{zw} + G_{zu} G_c (I - G_{yu} G_c)^{-1} G_{yw}

    Parameters
    ----------
    problem, N_c, D_c
        See :func:`~compensator_theory.loops._loop.close_loop`.

    Returns
    -------
    TransferMatrix
        l_z x l_w over the (monic) closed-loop characteristic polynomial.

    Raises
    ------
    InputError, ImproperError
        See :func:`~compensator_theory.loops._loop.close_loop`.

    Notes
    -----
    Source: (2.9), (2.11). Written as in (2.11), numerator and denominator share the factor D; it
    is a property of the formula and not of the loop, and it is divided out.

    Examples
    --------
    >>> from compensator_theory import standard_problem
    >>> from compensator_theory.loops import closed_loop_transfer_matrix
    >>> print(closed_loop_transfer_matrix(standard_problem("1/(q - 2)"), "-2", "q").scalar())
    (q)/(q**2 - 2*q + 2)
    """
    return close_loop(problem, N_c, D_c).from_w()


@carrying()
def closed_loop_zero_polynomial(
    problem: StandardProblem,
    N_c: PolynomialMatrixLike,
    D_c: PolynomialMatrixLike,
    w_channel: int = 0,
    z_channel: int = 0,
) -> Poly:
    r"""Return the numerator of one closed-loop map over the characteristic polynomial.

    .. math:: \tilde N_{zw} = \frac{N_{zu} N_{yw} N_c + N_{zw}(D D_c - N_{yu} N_c)}{D}

    Parameters
    ----------
    problem, N_c, D_c
        See :func:`~compensator_theory.loops._loop.close_loop`.
    w_channel, z_channel : int
        Which component of w and of z.

    Returns
    -------
    sympy.Poly
        The division by D is exact: :math:`N_{zu}N_{yw} - N_{zw}N_{yu}` is a 2 x 2 minor of a
        polynomial matrix over D and therefore divisible by D.

    Raises
    ------
    InputError, ImproperError
        See :func:`~compensator_theory.loops._loop.close_loop`; also if there is no such channel.

    Notes
    -----
    Source: (2.11), whose denominator D (D D_c - N_yu N_c) counts the n plant poles twice.

    Examples
    --------
    >>> from compensator_theory import standard_problem
    >>> from compensator_theory.loops import closed_loop_zero_polynomial
    >>> closed_loop_zero_polynomial(standard_problem("1/(q - 2)"), "-2", "q")
    Poly(q, q, domain='QQ')
    """
    require_problem(problem)
    if not (is_one_of(w_channel, range(problem.l_w)) and is_one_of(z_channel, range(problem.l_z))):
        raise InputError(
            f"there is no map from w[{repr_of(w_channel)}] to z[{repr_of(z_channel)}]: w "
            f"has {problem.l_w} and z has {problem.l_z} components"
        )
    return close_loop(problem, N_c, D_c).numerators_from_w()[z_channel][w_channel]
