"""The transfer function from the virtual control perturbation to the performance variable."""

from __future__ import annotations

from compensator_theory.loops._loop import PolynomialMatrixLike, close_loop
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.systems._standard_problems import StandardProblem
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix


@holds_where_defined
@carrying()
def intercalated_transfer_matrix(
    problem: StandardProblem, N_c: PolynomialMatrixLike, D_c: PolynomialMatrixLike
) -> TransferMatrix:
    r"""Return the map from :math:`\tilde u = u - \Phi\theta^*` to z with the loop closed.

    .. math:: \tilde G_{z\tilde u} = q^{n_c} G_{zu}\left[D_c^{-1}
              + G_c (I - G_{yu}G_c)^{-1} G_{yu} D_c^{-1}\right]
              = q^{n_c} N_{zu}\,(D D_c - N_c N_{yu})^{-1}

    Parameters
    ----------
    problem : StandardProblem
        The plant, of order n.
    N_c, D_c : polynomial or matrix
        The compensator :math:`u = D_c^{-1} N_c\,y` (positive feedback), D_c monic of degree n_c.

    Returns
    -------
    TransferMatrix
        l_z x l_u over the closed-loop characteristic polynomial, of order :math:`n + l_u n_c`.

    Raises
    ------
    InputError
        If shapes do not fit or D_c is not monic.
    ImproperError
        If the compensator is improper or :math:`\det(I - Q_0 D_0) = 0`, a hypothesis that the
        dissertation leaves open for :math:`k_c = 0`.

    Notes
    -----
    Source: (4.16).

    Examples
    --------
    >>> from compensator_theory import intercalated_transfer_matrix, standard_problem
    >>> plant = standard_problem("1/(q - 2)")
    >>> print(intercalated_transfer_matrix(plant, "-2", "q + 1")[0, 0])
    (q)/(q**2 - q)
    """
    loop = close_loop(problem, N_c, D_c)
    return loop.response(problem.variable**loop.n_c * identity_matrix(problem.l_u))


@holds_where_defined
@carrying()
def intercalated_transfer_function(
    problem: StandardProblem, N_c: PolynomialMatrixLike, D_c: PolynomialMatrixLike
) -> TransferFunction:
    r"""Return :func:`intercalated_transfer_matrix` for scalar u and z.

    .. math:: \tilde G_{z\tilde u} = \frac{N_{zu}\,q^{n_c}}{D D_c - N_{yu} N_c}

    Parameters
    ----------
    problem, N_c, D_c
        See :func:`intercalated_transfer_matrix`; u and z are scalar.

    Returns
    -------
    TransferFunction
        Not reduced: :math:`q^{n_c}` may cancel closed-loop poles at 0.

    Raises
    ------
    InputError, ImproperError
        As for the matrix; also if u or z is not scalar.

    Notes
    -----
    Source: (4.17), (4.18).

    Examples
    --------
    >>> from compensator_theory import intercalated_transfer_function, standard_problem
    >>> plant = standard_problem("(q - 0.5)/((q - 1)*(q - 2))")
    >>> print(intercalated_transfer_function(plant, "-3*q", "q**2"))
    (q**3 - q**2/2)/(q**4 - 3*q**3 + 5*q**2 - 3*q/2)
    """
    return intercalated_transfer_matrix(problem, N_c, D_c).scalar()


@carrying()
def control_perturbation_transfer_matrix(
    problem: StandardProblem, N_c: PolynomialMatrixLike, D_c: PolynomialMatrixLike
) -> TransferMatrix:
    r"""Return the map to z from a perturbation added to u outside the controller.

    .. math:: G_{z\bar u} = N_{zu}\,(D D_c - N_c N_{yu})^{-1} D_c

    Parameters
    ----------
    problem, N_c, D_c
        See :func:`intercalated_transfer_matrix`.

    Returns
    -------
    TransferMatrix
        l_z x l_u over the closed-loop characteristic polynomial.

    Raises
    ------
    InputError, ImproperError
        See :func:`intercalated_transfer_matrix`.

    Notes
    -----
    Source: (4.19), for any sizes.

    Examples
    --------
    >>> from compensator_theory import standard_problem
    >>> from compensator_theory.loops import control_perturbation_transfer_matrix
    >>> print(control_perturbation_transfer_matrix(standard_problem("1/(q-2)"), "-2", "q+1")[0, 0])
    (q + 1)/(q**2 - q)
    """
    loop = close_loop(problem, N_c, D_c)
    return loop.response(loop.D_c)


@carrying()
def control_perturbation_transfer_function(
    problem: StandardProblem, N_c: PolynomialMatrixLike, D_c: PolynomialMatrixLike
) -> TransferFunction:
    r"""Return :func:`control_perturbation_transfer_matrix` for scalar u and z.

    .. math:: G_{z\bar u} = \frac{N_{zu} D_c}{D D_c - N_{yu} N_c}

    Parameters
    ----------
    problem, N_c, D_c
        See :func:`intercalated_transfer_matrix`; u and z are scalar.

    Raises
    ------
    InputError, ImproperError
        As for the matrix; also if u or z is not scalar.

    Notes
    -----
    Source: (4.19). Unlike (4.18) its zeros include those of the compensator's denominator.

    Examples
    --------
    >>> from compensator_theory import standard_problem
    >>> from compensator_theory.loops import control_perturbation_transfer_function
    >>> print(control_perturbation_transfer_function(standard_problem("1/(q-2)"), "-2", "q+1"))
    (q + 1)/(q**2 - q)
    """
    return control_perturbation_transfer_matrix(problem, N_c, D_c).scalar()
