"""What parity interlacing asks of a plant with any number of signals: blocking zeros and poles."""

from functools import reduce
from typing import NamedTuple

from sympy import MatrixBase, Poly

from compensator_theory.canonical_forms.smith_mcmillan import smith_mcmillan_form
from compensator_theory.errors import InputError
from compensator_theory.polynomials.poly import canonical
from compensator_theory.roots.counts import require_rational
from compensator_theory.systems.conversions import transfer_function
from compensator_theory.systems.foreign import is_foreign
from compensator_theory.systems.matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems.realisations import Realisation
from compensator_theory.transfer_functions.transfer_functions import TransferFunction
from compensator_theory.transfer_functions.transfer_matrices import TransferMatrix


class Interlacing(NamedTuple):
    """The polynomials whose real roots interlace.

    Attributes
    ----------
    plant : TransferFunction or TransferMatrix
    zeros : sympy.Poly
        Its roots are the finite blocking zeros: there the whole matrix vanishes.
    poles : sympy.Poly
        Monic, of the McMillan degree.
    hidden : sympy.Poly
        The modes that no transfer function shows.
    is_strictly_proper : bool
        Whether infinity is a blocking zero.
    """

    plant: TransferFunction | TransferMatrix
    zeros: Poly
    poles: Poly
    hidden: Poly
    is_strictly_proper: bool


def interlacing(plant: TransferMatrixLike) -> Interlacing:
    """Return the blocking zeros, poles and hidden modes of a plant.

    Raises
    ------
    InputError
        If the plant is zero, improper or symbolic.

    Examples
    --------
    >>> from compensator_theory.stabilisation.blocking_zeros import interlacing
    >>> found = interlacing([["(s - 1)/s", 0], [0, "(s - 1)/(s*(s - 2))"]])
    >>> found.zeros.as_expr(), found.poles.as_expr()
    (s - 1, s**3 - 2*s**2)
    """
    G = _read(plant)
    matrix = G if isinstance(G, TransferMatrix) else transfer_matrix(G)
    entries = [entry for entry in _entries(matrix) if not entry.numerator.is_zero]
    if not entries:
        raise InputError("the plant 0 feels no input; it has no zeros to look at")
    for poly in (matrix.denominator, *(entry.numerator for entry in entries)):
        require_rational(poly)
    if not all(entry.is_proper for entry in entries):
        raise InputError(f"the plant {G} is improper; a realisable one has as many poles as zeros")
    reduced = [entry.reduced() for entry in entries]
    zeros = canonical(reduce(Poly.gcd, (entry.numerator for entry in reduced)))
    if matrix.shape == (1, 1):
        poles, knows_states = reduced[0].denominator, True
    else:
        poles, knows_states = smith_mcmillan_form(matrix).pole_polynomial, _has_states(plant)
    return Interlacing(
        G,
        zeros,
        poles,
        _hidden(matrix.denominator, poles, knows_states),
        all(entry.is_strictly_proper for entry in entries),
    )


def _read(plant: TransferMatrixLike) -> TransferFunction | TransferMatrix:
    is_rows = isinstance(plant, list | tuple) and all(isinstance(r, list | tuple) for r in plant)
    is_matrix = isinstance(plant, TransferMatrix | Realisation | MatrixBase)
    if not (is_rows or is_matrix or is_foreign(plant) or hasattr(plant, "shape")):
        return transfer_function(plant)
    G = transfer_matrix(plant)
    return G[0, 0] if G.shape == (1, 1) else G


def _entries(matrix: TransferMatrix) -> list[TransferFunction]:
    outputs, inputs = matrix.shape
    return [matrix[i, j] for i in range(outputs) for j in range(inputs)]


def _has_states(plant: object) -> bool:
    is_state_space = is_foreign(plant) and all(hasattr(plant, name) for name in "ABCD")
    return isinstance(plant, Realisation) or is_state_space


def _hidden(denominator: Poly, poles: Poly, knows_states: bool) -> Poly:
    """Return det(sI - A)/poles; of a common denominator what has no root among the poles.

    A common denominator says nothing of how often a pole occurs among the states.
    """
    if knows_states:
        return canonical(denominator.exquo(poles))
    rest = denominator
    while (common := rest.gcd(poles)).degree() > 0:
        rest = rest.exquo(common)
    return canonical(rest)
