"""Disturbance decoupling: whether state feedback can hide a disturbance from an output."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import ImmutableMatrix, Symbol

from compensator_theory._latex import displayed, latex, unless, words
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.placement._invariant_subspaces import (
    ControlledInvariantSubspaces,
    controlled_invariant_subspaces,
)
from compensator_theory.placement._subspaces import Subspaces
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._canonical_forms import RealisationLike, realisation

IDENTITY = "(C + D F)(A + B F)^k E = 0 for all k < n"


@dataclass(frozen=True)
class DisturbanceDecoupling(ExactValue):
    """Whether feedback hides a disturbance from the output, with the feedback.

    Attributes
    ----------
    is_solvable : bool
        Whether the image of E lies in V*, with symbols for generic values of them.
    F : sympy.ImmutableMatrix or None
        u = F x hides it; None where no gain does.
    subspaces : ControlledInvariantSubspaces
        V* and the symbols' exceptional set.
    certificate : Certificate or None
        The Markov parameters from the disturbance to the output, all zero; None with F.
    """

    _ANSWER = "is_solvable"

    is_solvable: bool
    F: ImmutableMatrix | None
    subspaces: ControlledInvariantSubspaces
    certificate: Certificate | None

    def __str__(self) -> str:
        if self.F is None:
            return "no state feedback hides the disturbance from the output"
        return f"u = F x with F = {text(self.F.tolist())} hides the disturbance from the output"

    def _repr_latex_(self) -> str:
        if self.F is None:
            return displayed(words(str(self)), unless(self.subspaces.exceptional))
        return displayed(f"u = F x, \\quad F = {latex(self.F)}", unless(self.subspaces.exceptional))


@carrying()
def decouple_disturbance(
    plant: RealisationLike, E: MatrixLike, *, variable: str | Symbol | None = None
) -> DisturbanceDecoupling:
    r"""Hide a disturbance from the output by state feedback, if that is possible.

    .. math:: \dot x = A x + B u + E w, \quad y = C x + D u; \qquad
              \mathrm{im}\,E \subset \mathcal V^*

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or input of :func:`realisation`
    E : matrix
        n x l: how the disturbance drives the states.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Raises
    ------
    InputError, ImproperError, BudgetError
        If the plant cannot be read, is improper or too large, or E does not fit.

    Notes
    -----
    The loop need not be stable; its modes in V* modulo R* are the zeros. Source: G. Basile, G.
    Marro (1969); W. M. Wonham, A. S. Morse, SIAM J. Control 8 (1970) 1-18.

    Examples
    --------
    >>> from compensator_theory.geometry import decouple_disturbance
    >>> A, B, C = [[0, 1, 0], [0, 0, 1], [0, 0, 0]], [[0], [1], [0]], [[1, 0, 0]]
    >>> print(decouple_disturbance((A, B, C), [[0], [0], [1]], variable="s"))
    u = F x with F = [[0, 0, -1]] hides the disturbance from the output
    >>> print(decouple_disturbance((A, B, C), [[1], [0], [0]], variable="s"))
    no state feedback hides the disturbance from the output
    """
    source, drive = realisation(plant, variable), exact_matrix(E, "E")
    if drive.rows != source.n or not drive.cols:
        raise InputError(
            f"E is {drive.rows} x {drive.cols}; it needs {source.n} rows, one for each state, and "
            "a column for each disturbance"
        )
    subspaces = controlled_invariant_subspaces(source)
    if not Subspaces().contains(subspaces.V, drive):
        return DisturbanceDecoupling(False, None, subspaces, None)
    closed, output = source.A + source.B * subspaces.F, source.C + source.D * subspaces.F
    left, power = [], drive
    for _ in range(source.n):
        left.append(output * power)
        power = closed * power
    return DisturbanceDecoupling(True, subspaces.F, subspaces, certificate_of(IDENTITY, left))
