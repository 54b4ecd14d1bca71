"""The kinds of zeros: invariant, transmission, input- and output-decoupling."""

from __future__ import annotations

from sympy import ImmutableMatrix, Symbol

from compensator_theory.forms._coprime_fractions import coprime_fractions
from compensator_theory.forms._smith import smith_form
from compensator_theory.forms._zero_directions import Zeros, zeros_of
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.systems._canonical_forms import RealisationLike, realisation
from compensator_theory.systems._matrix_conversions import TransferMatrixLike
from compensator_theory.systems._realisations import Realisation


@carrying()
def invariant_zeros(plant: RealisationLike, variable: str | Symbol | None = None) -> Zeros:
    r"""Find where Rosenbrock's system matrix loses rank.

    .. math:: P(s) = \begin{bmatrix} sI - A & -B \\ C & D \end{bmatrix}, \qquad
              P(z) \begin{bmatrix} x \\ u \end{bmatrix} = 0, \quad
              \begin{bmatrix} w' & y' \end{bmatrix} P(z) = 0

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or input of :func:`realisation`
        Hidden modes count. With symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Notes
    -----
    Below the normal rank: a plant with more inputs than outputs has a kernel everywhere, and its
    directions are then unique only up to that. Source: H. H. Rosenbrock, State-space and
    Multivariable Theory (1970).

    Examples
    --------
    >>> from compensator_theory import invariant_zeros
    >>> print(invariant_zeros(([[0, 1], [-2, -3]], [[0], [1]], [[5, 1]]), "s"))
    zeros of s + 5
    s + 5 = 0: state [1, -5], input [12], costate [1, 0], output [1]
    """
    system = realisation(plant, variable)
    upper = _pencil(system).row_join(-system.B)
    matrix = upper.col_join(system.C.row_join(system.D))
    smith = smith_form(matrix, system.variable)
    n = system.n
    return zeros_of(smith, smith, (n, system.B.cols), (n, system.C.rows))


@carrying()
def transmission_zeros(G: TransferMatrixLike, variable: str | Symbol | None = None) -> Zeros:
    r"""Find the transmission zeros and their directions.

    .. math:: G = N_r D_r^{-1} = D_l^{-1} N_l, \qquad N_r(z)\,v = 0, \quad u = D_r(z)\,v, \qquad
              w' N_l(z) = 0, \quad y' = w' D_l(z)

    Parameters
    ----------
    G : transfer matrix
        Anything :func:`transfer_matrix` reads, of any shape; of a realisation the hidden modes do
        not count. With symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Notes
    -----
    If z is no pole, then G(z) u = 0 and y' G(z) = 0. A target model of retrospective cost adaptive
    control must have the zero in the output direction y, or the controller may cancel it.

    Source: C. A. Desoer and J. D. Schulman, IEEE Transactions on Circuits and Systems 21 (1974).

    Examples
    --------
    >>> from compensator_theory import transmission_zeros
    >>> G = [["1/(s + 1)", "2/(s + 1)"], ["-1/((s + 1)*(s + 2))", "1/(s + 2)"]]
    >>> print(transmission_zeros(G))
    zeros of s + 3
    s + 3 = 0: input [2, -1], output [1, -1]
    """
    fractions = coprime_fractions(G, variable)
    right, left = smith_form(fractions.N_r), smith_form(fractions.N_l)
    zeros = zeros_of(
        right,
        left,
        (0, fractions.D_r.shape[0]),
        (0, fractions.D_l.shape[0]),
        fractions.D_r,
        fractions.D_l,
    )
    every = exceptional_factors([*zeros.exceptional, *fractions.exceptional])
    return Zeros(
        zeros.invariant_polynomials, zeros.polynomial, zeros.directions, every, zeros.certificate
    )


@carrying()
def input_decoupling_zeros(plant: RealisationLike, variable: str | Symbol | None = None) -> Zeros:
    r"""Find the input-decoupling zeros: the uncontrollable modes.

    .. math:: w' \begin{bmatrix} zI - A & -B \end{bmatrix} = 0

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or input of :func:`realisation`
        With symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Examples
    --------
    >>> from compensator_theory import input_decoupling_zeros
    >>> print(input_decoupling_zeros(([[-1, 0], [0, -2]], [[1], [0]], [[1, 1]]), "s"))
    zeros of s + 2
    s + 2 = 0: costate [0, 1]
    """
    system = realisation(plant, variable)
    return _decoupling_zeros(system, _pencil(system).row_join(-system.B), (0, 0), (system.n, 0))


@carrying()
def output_decoupling_zeros(plant: RealisationLike, variable: str | Symbol | None = None) -> Zeros:
    r"""Find the output-decoupling zeros: the unobservable modes.

    .. math:: \begin{bmatrix} zI - A \\ C \end{bmatrix} x = 0

    Parameters
    ----------
    plant : Realisation, (A, B, C), (A, B, C, D), or input of :func:`realisation`
        With symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`realisation`.

    Examples
    --------
    >>> from compensator_theory import output_decoupling_zeros
    >>> print(output_decoupling_zeros(([[-1, 0], [0, -2]], [[1], [1]], [[1, 0]]), "s"))
    zeros of s + 2
    s + 2 = 0: state [0, 1]
    """
    system = realisation(plant, variable)
    return _decoupling_zeros(system, _pencil(system).col_join(system.C), (system.n, 0), (0, 0))


def _pencil(plant: Realisation) -> ImmutableMatrix:
    return plant.variable * identity_matrix(plant.n) - plant.A


def _decoupling_zeros(
    plant: Realisation, matrix: ImmutableMatrix, right: tuple[int, int], left: tuple[int, int]
) -> Zeros:
    """Find where the pencil [sI - A, B] or [sI - A; C] loses rank."""
    smith = smith_form(matrix if plant.n else [[1]], plant.variable)
    return zeros_of(smith, smith, right, left)
