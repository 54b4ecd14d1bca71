"""Exact realisations from any description of a plant or compensator."""

from __future__ import annotations

from typing import Literal, TypeAlias

from sympy import Symbol

from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.matrices._exact_matrices import MatrixLike
from compensator_theory.matrices._flint_matrices import of_rows
from compensator_theory.polynomials._budget import repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._reading import is_one_of
from compensator_theory.polynomials._variables import as_symbol, time_of
from compensator_theory.systems._conversions import TransferFunctionLike, scalar_of
from compensator_theory.systems._descriptions import (
    Description,
    described,
    read_system,
    realised,
    shape_of,
)
from compensator_theory.systems._descriptor_systems import DescriptorSystem
from compensator_theory.systems._kinds import States
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._sample_times import sampled_every
from compensator_theory.systems._state_space import controllable_canonical_form
from compensator_theory.systems._transfer_functions import TransferFunction

RealisationLike: TypeAlias = Realisation | TransferFunctionLike
"""Input types of :func:`realisation`."""


@holds_where_defined
@carrying()
def realisation(
    obj: RealisationLike,
    variable: str | Symbol | None = None,
    *,
    form: Literal["controllable", "observable"] = "controllable",
    sample_time: NumberLike | None = None,
) -> Realisation:
    r"""Make an exact realisation out of matrices, a transfer function or a python-control system.

    .. math:: G = C(sI - A)^{-1}B + D

    Parameters
    ----------
    obj : Realisation, (A, B, C), (A, B, C, D), python-control system or transfer function
        Matrices as for :func:`transfer_function`.
        A transfer function, anything :func:`transfer_function` reads, is realised in canonical
        form with its common factors; a state-space system keeps its basis.
    variable : str or Symbol, optional
        Default: that of the transfer function; bare matrices need it, since they do not show the
        time domain.
    form : {"controllable", "observable"}
        Which canonical form: a common factor is unobservable in the first, uncontrollable in the
        second.
    sample_time : number, optional
        As for :func:`transfer_function`.

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
    if not is_one_of(form, ("controllable", "observable")):
        raise InputError(f"form is 'controllable' or 'observable', not {repr_of(form)}")
    system = _read(obj, variable, form)
    return system if sample_time is None else sampled_every(system, sample_time)


def _read(obj: RealisationLike, variable: str | Symbol | None, form: str) -> Realisation:
    contents = read_system(obj, variable)
    if isinstance(contents, States):
        return realised(contents, variable)
    if isinstance(contents, DescriptorSystem):
        contents = contents.realisation()
    if not isinstance(contents, Realisation):
        return _canonical(contents, variable, form)
    if variable is not None and as_symbol(variable) != contents.variable:
        raise InputError(f"the realisation has the variable {contents.variable}, not {variable}")
    return contents


def timed_realisation(
    obj: RealisationLike, variable: str | Symbol | None, subject: str
) -> Realisation:
    """Read a realisation for a question whose answer depends on time, which is never guessed."""
    description = described(obj, variable)
    if variable is None and isinstance(description, States) and description.sample_time is None:
        raise InputError(
            f"{subject} depends on the time domain, which matrices do not show; write variable='s' "
            "for continuous time, 'z' or 'q' for discrete time"
        )
    read = realisation(obj, variable)
    time_of(read.variable, subject)
    return read


def _canonical(source: Description, variable: str | Symbol | None, form: str) -> Realisation:
    if (shape := shape_of(source, variable)) != (1, 1):
        raise InputError(
            f"a transfer matrix of {shape[0]} outputs and {shape[1]} inputs has no scalar "
            "canonical form; give minimal_realisation(G).realisation"
        )
    G = scalar_of(source, variable)
    A, B, C, D = controllable_canonical_form(G)
    if form == "observable":
        A, B, C = A.T, C.T, B.T
    return verified_realisation(A, B, C, D, G)


def verified_realisation(
    A: MatrixLike, B: MatrixLike, C: MatrixLike, D: MatrixLike, G: TransferFunction
) -> Realisation:
    """The realisation of a transfer function, compared with it."""
    s = G.variable
    candidate = Realisation(A, B, C, D, s, feedback=G.feedback, sample_time=G.sample_time)
    back = candidate.transfer_function()
    left = back.numerator - G.numerator, back.denominator - G.denominator
    residual = of_rows([[p.as_expr() if p else 0 for p in left]], (1, 2))
    identity = f"C adj({s.name}I - A) B + D det({s.name}I - A) = N, det({s.name}I - A) = D"
    certificate = Certificate(identity, residual)
    if not certificate.holds:
        raise InputError(f"{certificate}: these matrices do not realise {G}")
    object.__setattr__(candidate, "certificate", certificate)  # reading the matrices again is slow
    return candidate
