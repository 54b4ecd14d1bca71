"""A realisation from Markov parameters: the eigensystem realisation algorithm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import real_array
from rcac_numeric.arrays._values import Result
from rcac_numeric.identification._order import hankel_matrix, order_from_singular_values


@dataclass(frozen=True, eq=False)
class EigensystemRealisation(Result):
    """A balanced realisation of Markov parameters, by a singular value decomposition.

    Attributes
    ----------
    A, B, C, D : arrays, shapes (n, n), (n, l_u), (l_z, n), (l_z, l_u)
        H_0 = D and H_i is close to C A^(i-1) B.
    singular_values : array
        Of the Hankel matrix; those beyond the n-th were set to zero.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    singular_values: Array

    @property
    def n(self) -> int:
        """Number of states."""
        return int(self.A.shape[0])


def eigensystem_realisation(
    H: ArrayLike, order: int | None = None, error: ArrayLike = 0.0, *, stable: bool = False
) -> EigensystemRealisation:
    """Realise Markov parameters by the eigensystem realisation algorithm (ERA), section 3.6.

    A = S^(-1/2) U' K_1 V S^(-1/2),  K_0 = U S V',  K_s = [H_(i+j+1+s)], i, j = 0, 1, ...

    Parameters
    ----------
    H : array, shape (number of parameters, l_z, l_u)
        H_0 first; a 1-D array stands for a scalar system. K_0 and K_1 are as square as possible
        and use every parameter.
    order : int, optional
        Number of states n. By default the number of singular values of K_0 that exceed the
        Frobenius norm of the matrix with the errors of its entries: a singular value above the
        norm of the error cannot come from the error alone.
    error : array that can be broadcast to the shape of H
        Standard error of each parameter, for the default order; an error of
        eps * max(abs(H)) * (side of K_0) is assumed at least.
    stable : bool
        Take A = S^(-1/2) U' (U one block higher, zeros below) S^(1/2), whose eigenvalues are
        inside the unit circle whatever the data: U' and the shift have norm 1, and the shift has
        no eigenvalue but 0. It costs a bias where the parameters have not died out at the end of
        K_0, and stabilises an unstable plant wrongly.

    Raises
    ------
    InputError
        If the parameters are too few to carry this order, or the errors are negative or do not
        fit the shape of H.

    Notes
    -----
    Source: [96] of the text, J.-N. Juang and R. S. Pappa, An eigensystem realization algorithm for
    modal parameter identification and model reduction, Journal of Guidance, Control, and Dynamics
    8 (1985); `stable` after J. M. Maciejowski, Guaranteed stability with subspace
    methods, Systems and Control Letters 26 (1995). The same realisation, up to the sign of each
    state, as `control.eigensys_realization` gives for the same Hankel matrix.

    Examples
    --------
    >>> from rcac_numeric.identification import eigensystem_realisation
    >>> model = eigensystem_realisation([0, 1, 0.5, 0.25, 0.125, 0.0625])
    >>> model.A.round(12)
    array([[0.5]])
    """
    parameters = real_array(H, "H")
    parameters = parameters.reshape(-1, 1, 1) if parameters.ndim == 1 else parameters
    if parameters.ndim != 3 or len(parameters) < 3:
        raise InputError(
            f"H has shape {parameters.shape}; at least H_0, H_1, H_2 of shape (l_z, l_u) are "
            "needed."
        )
    rows = len(parameters) // 2
    columns = len(parameters) - 1 - rows
    _, l_z, l_u = parameters.shape
    n, size = order_from_singular_values(parameters, _errors(error, parameters.shape), order)
    K_0, K_1 = (hankel_matrix(parameters, 1 + shift, rows, columns) for shift in (0, 1))
    U, _, Vt = np.linalg.svd(K_0)
    root = np.sqrt(size[:n])
    left, right = U[:, :n] / root, (Vt[:n] / root[:, None]).T
    if stable:
        up = np.vstack([U[l_z:, :n], np.zeros((l_z, n))])
        A = left.T @ (up * root)
    else:
        A = left.T @ K_1 @ right
    return EigensystemRealisation(
        A=A,
        B=(root[:, None] * Vt[:n])[:, :l_u],
        C=(U[:, :n] * root)[:l_z],
        D=parameters[0].copy(),
        singular_values=size,
    )


def _errors(error: ArrayLike, shape: tuple[int, ...]) -> Array:
    errors = real_array(error, "error")
    try:
        fitted = np.broadcast_to(errors, shape)
    except ValueError:
        raise InputError(
            f"error has shape {errors.shape}, which does not fit H of shape {shape}."
        ) from None
    if (fitted < 0).any():
        raise InputError(f"error has the entry {fitted.min():g}; a standard error is at least 0.")
    return fitted
