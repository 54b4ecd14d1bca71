"""Modelling information from identified Markov parameters."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import real_array
from rcac_numeric.identification._era import eigensystem_realisation
from rcac_numeric.identification._mu_markov import IdentifiedMarkovParameters
from rcac_numeric.targets._modelling import ModellingInformation


def modelling_information_from_markov(
    H: IdentifiedMarkovParameters | ArrayLike,
    *,
    order: int | None = None,
    significance: float = 5.0,
) -> ModellingInformation:
    """Relative degree, leading coefficient and NMP zeros of a scalar G_zu from Markov parameters.

    d_zu is the index of the first significant parameter. With H = H_d_zu and a realisation
    (A, B, C) of H_(d_zu+1), H_(d_zu+2), ..., that is, of q^d_zu G_zu - H, the zeros are the
    eigenvalues of

    A - B C / H:  those of G_zu, and d_zu at 0.

    Parameters
    ----------
    H : IdentifiedMarkovParameters, or array of Markov parameters with H_0 first
        Plain numbers are taken to be exact but for rounding: a parameter is then significant if
        it exceeds `significance` * eps * max(abs(H)).
    order : int, optional
        Order of G_zu; by default as `eigensystem_realisation` decides from the standard errors.
    significance : float
        A parameter is significant if it exceeds this many standard errors. At 5 one in about two
        million insignificant parameters is taken for significant.

    Returns
    -------
    ModellingInformation
        With the zeros of modulus at least 1. For the servo problem the identified map from u to z,
        and not G_u, gives the right sign.

    Raises
    ------
    InputError
        If no parameter is significant, too few follow the first one for the order, or the map is
        not scalar.

    Notes
    -----
    Shifting by d_zu keeps insignificant leading parameters from creating large spurious zeros,
    which they do where the zeros of a realisation of G_zu itself are taken.

    Examples
    --------
    >>> from rcac_numeric import standard_plant
    >>> from rcac_numeric.identification import modelling_information_from_markov
    >>> from rcac_numeric.targets import markov_parameters
    >>> H = markov_parameters(standard_plant("2*(q - 1.5)/(q*(q - 0.5)*(q - 0.2))"), count=13)
    >>> known = modelling_information_from_markov(H)
    >>> known.d_zu, known.H, [round(zero, 9) for zero in known.nmp_zeros]
    (2, 2.0, [1.5])
    """
    if isinstance(H, IdentifiedMarkovParameters):
        cleared, error = H.cleared(significance), H.standard_error
    else:
        cleared = np.array(real_array(H, "H"))
        cleared = cleared.reshape(-1, 1, 1) if cleared.ndim == 1 else cleared
        if cleared.ndim == 0:
            raise InputError(f"H = {float(cleared):g} is a number; H_0, H_1, ... are needed.")
        rounding = np.finfo(float).eps * np.abs(cleared).max(initial=0.0)
        error = np.full(cleared.shape, rounding)
        insignificant = np.cumsum(np.abs(cleared) > significance * rounding, axis=0) == 0
        cleared[insignificant] = 0.0
    if cleared.ndim != 3 or cleared.shape[1:] != (1, 1):
        raise InputError(
            f"the Markov parameters have shape {cleared.shape}; modelling information is for "
            "scalar z and u. Use markov_target for a matrix."
        )
    if not cleared.any():
        raise InputError(
            f"none of the {len(cleared)} Markov parameters exceeds {significance:g} standard "
            "errors: the data show no effect of u on z. Record more data, or a stronger input."
        )
    d_zu = int(np.flatnonzero(cleared)[0])
    leading = float(cleared[d_zu, 0, 0])
    shifted = cleared[d_zu:]
    if len(shifted) < 3:
        raise InputError(
            f"only {len(shifted) - 1} Markov parameters follow the first significant one, "
            f"H_{d_zu}; zeros need at least 2. Estimate more of them: a larger mu."
        )
    model = eigensystem_realisation(shifted, order, error[d_zu:])
    zeros = np.linalg.eigvals(model.A - model.B @ model.C / leading)
    outside = sorted(zeros[np.abs(zeros) >= 1], key=lambda zero: (-abs(zero), -zero.imag))
    return ModellingInformation(d_zu, leading, tuple(_plain(zero) for zero in outside))


def _plain(zero: complex) -> complex | float:
    return float(zero.real) if zero.imag == 0 else complex(zero)
