"""Everything that describes a plant or a compensator, to an exact realisation."""

from typing import Literal, TypeAlias

from sympy import Symbol

from compensator_theory.errors import InputError
from compensator_theory.matrices.exact_matrices import MatrixLike
from compensator_theory.polynomials.budget import shown
from compensator_theory.polynomials.variables import as_symbol
from compensator_theory.systems.conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems.foreign import Matrices, contents_of, is_foreign
from compensator_theory.systems.realisations import Realisation, verified_realisation
from compensator_theory.systems.state_space import controllable_canonical_form

RealisationLike: TypeAlias = (
    Realisation
    | tuple[MatrixLike, MatrixLike, MatrixLike]
    | tuple[MatrixLike, MatrixLike, MatrixLike, MatrixLike]
    | TransferFunctionLike
)
"""What :func:`realisation` reads."""


def realisation(
    obj: RealisationLike,
    variable: str | Symbol | None = None,
    *,
    form: Literal["controllable", "observable"] = "controllable",
) -> Realisation:
    r"""Make an exact realisation out of matrices, a transfer function or a python-control system.

    .. math:: G = C(sI - A)^{-1}B + D

    Parameters
    ----------
    obj : Realisation, (A, B, C), (A, B, C, D), python-control system or transfer function
        A transfer function, anything :func:`transfer_function` reads, is realised in canonical
        form with its common factors; a state-space system keeps its basis.
    variable : str or Symbol, optional
        Default: that of the transfer function; ``s`` for matrices.
    form : {"controllable", "observable"}
        Which canonical form: a common factor is unobservable in the first, uncontrollable in the
        second.

    Returns
    -------
    Realisation

    Raises
    ------
    InputError, ImproperError
        If the description cannot be read, or the transfer function is improper.

    Notes
    -----
    Source: (7.26), (7.29).

    Examples
    --------
    >>> from compensator_theory import realisation
    >>> realisation("4/(s**2 + 4*s + 3)", form="observable").A
    Matrix([
    [0, -3],
    [1, -4]])
    """
    if form not in ("controllable", "observable"):
        raise InputError(f"form is 'controllable' or 'observable', not {shown(form)}")
    if isinstance(obj, Realisation):
        if variable is not None and as_symbol(variable) != obj.variable:
            raise InputError(f"the realisation has the variable {obj.variable}, not {variable}")
        return obj
    if isinstance(obj, tuple | list) and len(obj) in (3, 4):
        symbol = as_symbol("s" if variable is None else variable)
        A, B, C = obj[:3]
        return Realisation(A, B, C, obj[3] if len(obj) == 4 else None, symbol)
    if is_foreign(obj):
        found = contents_of(obj, variable)
        if isinstance(found, Matrices):
            return Realisation(
                found.A, found.B, found.C, found.D, found.variable, sample_time=found.sample_time
            )
    return _canonical(obj, variable, form)


def _canonical(obj: TransferFunctionLike, variable: str | Symbol | None, form: str) -> Realisation:
    G = transfer_function(obj, variable)
    A, B, C, D = controllable_canonical_form(G)
    if form == "observable":
        A, B, C = A.T, C.T, B.T
    return verified_realisation(A, B, C, D, G)
