"""Realisations of least order, by Ho and Kalman's algorithm or from a larger realisation."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, ImmutableMatrix, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.forms._expansions import markov_parameters
from compensator_theory.forms._hankel_matrices import (
    block_rows,
    hankel_matrix,
    places,
    proper_entry,
)
from compensator_theory.forms._kalman import kalman_decomposition
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import zero_matrix
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._descriptions import has_states
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._transfer_matrices import TransferMatrix

IDENTITY = "the transfer matrix of the realisation times D, less N times its denominator"


@dataclass(frozen=True)
class MinimalRealisation(ExactValue):
    """A realisation of least order, with the certificate that it has the given transfer matrix.

    Attributes
    ----------
    realisation : Realisation
        Controllable and observable, for symbols outside the exceptional set.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the realisation exists and is minimal where none of
        them is zero. Empty without symbols.
    certificate : Certificate
        Its transfer matrix against the source, multiplied out.
    """

    realisation: Realisation
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def order(self) -> int:
        """Number of states, the McMillan degree."""
        return self.realisation.n

    def __str__(self) -> str:
        return str(self.realisation)

    def _repr_latex_(self) -> str:
        name = r"\begin{bmatrix} A & B \\ C & D \end{bmatrix}"
        return displayed(f"{name} = {latex(self.realisation)}", unless(self.exceptional))


@carrying()
def minimal_realisation(
    G: TransferMatrixLike | RealisationLike, variable: str | Symbol | None = None
) -> MinimalRealisation:
    r"""Realise a proper transfer matrix, or reduce a realisation, with the least number of states.

    .. math:: \mathcal H^{\uparrow}_I = A\,\mathcal H_I, \qquad B = \mathcal H_{I1}, \qquad
              \mathcal H_1 = C\,\mathcal H_I

    Parameters
    ----------
    G : transfer matrix or realisation
        Anything :func:`transfer_matrix` or :func:`realisation` reads; a tuple of three or four
        matrices is (A, B, C, D). A realisation is reduced by Kalman's decomposition; from a
        transfer matrix the first independent rows I of its block Hankel matrix are taken (Ho and
        Kalman), for one signal each a companion form.
    variable : str or Symbol, optional
        As for the readers.

    Raises
    ------
    ImproperError
        If an entry is improper.
    InputError, BudgetError
        If it cannot be read, or is too large.

    Notes
    -----
    Source: B. L. Ho and R. E. Kalman, Effective construction of linear state-variable models from
    input/output functions, Regelungstechnik 14 (1966).

    Examples
    --------
    >>> from compensator_theory import minimal_realisation
    >>> G = [["1/(s + 1)", "2/(s + 1)"], ["-1/((s + 1)*(s + 2))", "1/(s + 2)"]]
    >>> print(minimal_realisation(G))
    A = [[-1, 0, 0], [0, 0, 1], [0, -2, -3]]
    B = [[1, 2], [0, 1], [-1, -2]]
    C = [[1, 0, 0], [0, 1, 0]]
    """
    if has_states(G, variable):
        plant = realisation(G, variable)
        parts = kalman_decomposition(plant)
        source = plant.transfer_matrix()
        return _checked(parts.minimal, source, parts.exceptional)
    source = transfer_matrix(G, variable)
    size = block_rows(source)
    D = ImmutableMatrix(
        *source.shape,
        [markov_parameters(proper_entry(source, i, j), 1)[0] for i, j in places(source)],
    )
    whole = hankel_matrix(source, size + 1, size) if size else zero_matrix(0, 0)
    outputs, inputs = source.shape
    # x = the outputs I of the free motion: their rows of the Hankel matrix are the basis, of which
    # every row is a combination, those that are a step later included.
    rows = echelon(whole.T)
    combinations = rows.matrix.T
    A, C = combinations[[i + outputs for i in rows.pivots], :], combinations[:outputs, :]
    B = whole[list(rows.pivots), :inputs]
    n = len(rows.pivots)
    system = Realisation(
        A if n else zero_matrix(0, 0),
        B if n else zero_matrix(0, inputs),
        C if n else zero_matrix(outputs, 0),
        D,
        source.variable,
        sample_time=source.sample_time,
    )
    return _checked(system, source, exceptional_factors([rows.divided_by]))


def _checked(
    minimal: Realisation, source: TransferMatrix, exceptional: tuple[Expr, ...]
) -> MinimalRealisation:
    back = minimal.transfer_matrix()
    residual = [
        canonical(mine * source.denominator - source_entry * back.denominator).as_expr()
        for my_row, row in zip(back.numerators, source.numerators, strict=True)
        for mine, source_entry in zip(my_row, row, strict=True)
    ]
    certificate = certificate_of(IDENTITY, [residual], "realisation")
    return MinimalRealisation(minimal, exceptional, certificate)
