"""Output-subspace zeros: the limits of RCAC for more performance variables than inputs.

RCAC sees z through H' z, H being the Markov parameter of its target model, and so squares a tall
plant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from sympy import Matrix, Poly, Symbol

import compensator_theory as exact
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._linear_algebra import determinant
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import rounded
from rcac_numeric.arrays._values import Result
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._transmission_zeros import rosenbrock_matrix
from rcac_numeric.targets._markov import markov_parameters
from rcac_numeric.targets._model import TargetModel
from rcac_numeric.targets._modelling import Number, factor_not_inside, zeros_not_inside


@dataclass(frozen=True, eq=False)
class OutputSubspaceZeros(Result):
    """The zeros from u to H' z of section 3.4.1.

    Attributes
    ----------
    d_zu : int
        Relative degree: index of the first nonzero Markov parameter of G_zu.
    H : array, shape (l_z, l_u)
        That parameter, rounded once.
    polynomial : sympy.Poly
        Monic in q, exact; its roots are the zeros, with multiplicity.
    nmp_zeros : tuple
        The zeros on or outside the unit circle, decided exactly.
    """

    d_zu: int
    H: Array
    polynomial: Poly
    nmp_zeros: tuple[Number, ...]

    def __str__(self) -> str:
        shown = ", ".join(f"{zero:.6g}" for zero in self.zeros) or "none"
        return f"output-subspace zeros: {shown}; {len(self.nmp_zeros)} not inside the unit circle"

    @property
    def zeros(self) -> ComplexArray:
        """All output-subspace zeros, from certified isolation."""
        if self.polynomial.degree() < 1:
            return np.zeros(0, dtype=np.complex128)
        roots = exact.certified_roots(self.polynomial)
        return np.array([r.value for r in roots for _ in range(r.multiplicity)])


def output_subspace_zeros(plant: Plant) -> OutputSubspaceZeros:
    """The output-subspace zeros of a plant with l_z >= l_u, section 3.4.1.

    det [ qI - A, -B ; H' E_1, H' E_2 ] = 0,  H = H_d_zu

    Parameters
    ----------
    plant : Plant
        For the servo problem G_zu = -G_u, which changes no zero.

    Raises
    ------
    InputError
        If l_z < l_u: H' z = 0 then leaves no freedom for z if H has full rank, and the zeros are
        those of `transmission_zero_polynomial`; or if G_zu = 0.
    NoSolutionError
        If the squared plant H' G_zu is singular for every q, so that zeros are undefined.

    Notes
    -----
    For square G_zu with nonsingular H these are the transmission zeros, exactly. The text infers
    N(H') = {0} from the rank of G_zu; it is the rank of H that counts, and H may be singular
    where G_zu is not, as for G_zu = diag(1/q, 1/q^2).

    Examples
    --------
    >>> from rcac_numeric import Plant, transmission_zero_polynomial
    >>> from rcac_numeric.targets import output_subspace_zeros
    >>> full_state = Plant(A=[[0.5, 0.0], [0.0, 0.9]], B=[[1.0], [2.0]], D_1=[[1.0], [0.0]],
    ...                    C=[[1.0, 0.0], [0.0, 1.0]])
    >>> transmission_zero_polynomial(full_state).degree()
    0
    >>> output_subspace_zeros(full_state).zeros
    array([0.58+0.j])
    """
    plant = linear_plant(plant)
    if plant.l_z < plant.l_u:
        raise InputError(
            f"G_zu is {plant.l_z} x {plant.l_u}, wider than tall; output-subspace zeros are for "
            "l_z >= l_u. Use transmission_zero_polynomial."
        )
    parameters = markov_parameters(plant, plant.n + 1)
    nonzero = np.flatnonzero(parameters.any(axis=(1, 2)))
    if nonzero.size == 0:
        raise InputError("G_zu = 0: the control does not act on z.")
    d_zu = int(nonzero[0])
    H = _exact_parameter(plant, d_zu)
    polynomial = Poly(determinant(rosenbrock_matrix(plant, H.T)), Symbol("q"), domain="QQ")
    if polynomial.is_zero:
        raise NoSolutionError(
            f"H' G_zu is singular for every q, because the first nonzero Markov parameter H = "
            f"{parameters[d_zu].tolist()} does not have full column rank. Choose other "
            "performance variables."
        )
    monic = polynomial.monic()
    return OutputSubspaceZeros(d_zu, parameters[d_zu], monic, zeros_not_inside(monic))


def output_subspace_target(plant: Plant) -> TargetModel:
    """The FIR target model with the NMP output-subspace zeros, section 3.3.

    G_f(q) = H N_osz,u(q) / q^(d_zu + deg N_osz,u)

    Parameters
    ----------
    plant : Plant
        With l_z >= l_u.

    Raises
    ------
    InputError, NoSolutionError
        As `output_subspace_zeros`.

    Examples
    --------
    >>> from rcac_numeric import Plant
    >>> from rcac_numeric.targets import output_subspace_target
    >>> plant = Plant(A=[[0.5, 0.0], [0.0, 0.9]], B=[[1.0], [2.0]], D_1=[[1.0], [0.0]],
    ...               C=[[1.0, 0.0], [0.0, 1.0]])
    >>> output_subspace_target(plant).numerator[1].ravel()
    array([1., 2.])
    """
    zeros = output_subspace_zeros(plant)
    polynomial = factor_not_inside(zeros.polynomial)
    factor = exact.polynomial_from_roots(zeros.nmp_zeros, "q") if polynomial is None else polynomial
    N_u = rounded(factor.all_coeffs(), "the output-subspace zeros")
    delay = np.zeros(zeros.d_zu)
    numerator = np.multiply.outer(np.concatenate([delay, N_u]), zeros.H)
    if polynomial is None:
        return TargetModel(numerator)
    H = _exact_parameter(linear_plant(plant), zeros.d_zu)
    q_to_n = Poly(polynomial.gen ** (zeros.d_zu + polynomial.degree()), polynomial.gen)
    entries = tuple(tuple(factor * H[i, j] for j in range(H.cols)) for i in range(H.rows))
    if H.shape == (1, 1):
        return TargetModel(numerator, exact=exact.TransferFunction(entries[0][0], q_to_n))
    return TargetModel(numerator, exact=exact.TransferMatrix(entries, q_to_n))


def _exact_parameter(plant: Plant, index: int) -> Matrix:
    problem = plant.problem
    return problem.E_2 if index == 0 else problem.E_1 * problem.A ** (index - 1) * problem.B
