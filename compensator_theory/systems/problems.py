"""The usual standard problems, built from a transfer function or from a realisation."""

from __future__ import annotations

from typing import Literal

import sympy
from sympy import ImmutableMatrix, Rational, Symbol

from compensator_theory.errors import ImproperError, InputError
from compensator_theory.matrices.exact_matrices import MatrixLike, exact_matrix
from compensator_theory.polynomials.budget import shown
from compensator_theory.polynomials.reading import is_one_of
from compensator_theory.systems.conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems.standard_problems import StandardProblem
from compensator_theory.systems.state_space import controllable_canonical_form

_SERVO_MATRICES = ("A", "B", "D_1", "C", "D_0")


def standard_problem(
    G: TransferFunctionLike, variable: str | Symbol | None = None
) -> StandardProblem:
    r"""Make the SISO plant whose measurement is its performance and whose disturbance is matched.

    .. math:: G = G_{zw} = G_{yw} = G_{zu} = G_{yu} = N/D

    Parameters
    ----------
    G : transfer function
        Proper; anything :func:`transfer_function` reads.
    variable : str or Symbol, optional
        Variable of G.

    Returns
    -------
    StandardProblem
        In controllable canonical form; a common factor of N and D stays in it.

    Raises
    ------
    ImproperError
        If G is improper.

    Notes
    -----
    Source: (2.15).

    Examples
    --------
    >>> from compensator_theory import standard_problem
    >>> plant = standard_problem("(q - 0.5)/(q**2 - 1)")
    >>> plant.numerator("zu"), plant.denominator
    (Poly(q - 1/2, q, domain='QQ'), Poly(q**2 - 1, q, domain='QQ'))
    """
    plant = transfer_function(G, variable)
    A, B, C, D = controllable_canonical_form(plant)
    return StandardProblem(A, B, C, B, D, D, C, D, D, plant.variable, plant.sample_time)


def servo_problem(
    G: TransferFunctionLike | None = None,
    *,
    A: MatrixLike | None = None,
    B: MatrixLike | None = None,
    D_1: MatrixLike | None = None,
    C: MatrixLike | None = None,
    D_0: MatrixLike | None = None,
    performance: Literal["measured", "true"] = "measured",
    variable: str | Symbol | None = None,
    sample_time: Rational | None = None,
) -> StandardProblem:
    r"""Make the servo problem with :math:`w = (r, d, v)` and measurement :math:`e_n`.

    .. math::
        x(k+1) = A x + B u + \bar D_1 d, \quad y_0 = \bar C x + \bar D_0 u, \quad
        e_0 = r - y_0, \quad e_n = e_0 - v

    Parameters
    ----------
    G : transfer function, optional
        Strictly proper SISO plant, with the disturbance at the plant's input.
    A, B, D_1, C, D_0 : matrix, optional
        Instead of G; D_1 defaults to B (colocated), D_0 to zero.
    performance : {"measured", "true"}
        Whether z is :math:`e_n`, the signal available to an adaptive controller, or :math:`e_0`.
    variable : str or Symbol, optional
        Variable of G, or of the maps (default q).
    sample_time : Rational, optional
        In seconds; default: that of G.

    Returns
    -------
    StandardProblem
        With :math:`C = E_1 = -\bar C`, :math:`D_0 = E_2 = -\bar D_0`,
        :math:`D_2 = [I\ 0\ {-I}]`, and :math:`E_0 = D_2` or :math:`[I\ 0\ 0]`.

    Raises
    ------
    ImproperError
        If G is not strictly proper.
    InputError
        If the data are incomplete or their shapes do not fit.

    Notes
    -----
    Source: (2.16)-(2.27). Erratum: (2.26) prints :math:`E_0 = [I\ 0\ 0]`, and (2.27) the
    corresponding :math:`G_{zw}`, which belong to :math:`z = e_0`; (2.24) defines
    :math:`z = e_n`, for which :math:`E_0 = [I\ 0\ {-I}]`. The default follows (2.24).

    Examples
    --------
    >>> from compensator_theory import servo_problem
    >>> servo = servo_problem("1/(q - 0.5)")
    >>> servo.E_0, servo_problem("1/(q - 0.5)", performance="true").E_0
    (Matrix([[1, 0, -1]]), Matrix([[1, 0, 0]]))
    >>> print(servo.transfer_function("zu"))
    (-1)/(q - 1/2)
    """
    if not is_one_of(performance, ("measured", "true")):
        raise InputError(f"performance is 'measured' or 'true', not {shown(performance)}")
    given = dict(zip(_SERVO_MATRICES, (A, B, D_1, C, D_0), strict=True))
    if G is not None:
        if any(value is not None for value in given.values()):
            raise InputError("give either a transfer function or matrices, not both")
        plant = transfer_function(G, variable)
        if not plant.is_strictly_proper:
            raise ImproperError(
                f"the plant {plant} is not strictly proper, so that a disturbance at its input "
                "does not reach the output as u does; give the matrices A, B, D_1, C, D_0"
            )
        given["A"], given["B"], given["C"], _ = controllable_canonical_form(plant)
        variable = plant.variable
        sample_time = plant.sample_time if sample_time is None else sample_time
    missing = [name for name in ("A", "B", "C") if given[name] is None]
    if missing:
        raise InputError(f"the servo problem lacks {', '.join(missing)}; D_1 and D_0 are optional")
    matrices = {k: exact_matrix(v, k) for k, v in given.items() if v is not None}
    matrices.setdefault("D_1", matrices["B"])
    l_y, l_u = matrices["C"].rows, matrices["B"].cols
    matrices.setdefault("D_0", ImmutableMatrix.zeros(l_y, l_u))
    symbol = "q" if variable is None else variable
    return _servo(matrices, performance, symbol, sample_time)


def _servo(
    matrices: dict[str, ImmutableMatrix],
    performance: str,
    variable: str | Symbol,
    sample_time: Rational | None,
) -> StandardProblem:
    A, D_1, C, D_0 = (matrices[name] for name in ("A", "D_1", "C", "D_0"))
    l_y, l_d = C.rows, D_1.cols
    if D_1.rows != A.rows:
        raise InputError(f"D_1 has {D_1.rows} rows but the plant has {A.rows} states")
    identity, no_command = sympy.eye(l_y), sympy.zeros(A.rows, l_y)
    no_disturbance = sympy.zeros(l_y, l_d)
    measured = sympy.Matrix.hstack(identity, no_disturbance, -identity)
    true = sympy.Matrix.hstack(identity, no_disturbance, sympy.zeros(l_y, l_y))
    return StandardProblem(
        A=A,
        B=matrices["B"],
        C=-C,
        D_1=sympy.Matrix.hstack(no_command, D_1, no_command),
        D_0=-D_0,
        D_2=measured,
        E_1=-C,
        E_2=-D_0,
        E_0=measured if performance == "measured" else true,
        variable=variable,
        sample_time=sample_time,
    )
