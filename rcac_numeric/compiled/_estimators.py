"""The kernel's estimators, and error messages for their failures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from compensator_theory.errors import (
    CompensatorError,
    DivergedError,
    FunctionFailedError,
    IllConditionedError,
)
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.compiled import _kernel

Filter = _kernel.Filter
Refinement = _kernel.Refinement
EstimationModel = _kernel.EstimationModel
EstimationError = _kernel.EstimationError
Tape = tuple[Array, NDArray[np.int32], NDArray[np.int32]]  # constants, steps, results

Arx = _kernel.Arx
make_arx = _kernel.arx
make_mu_markov = _kernel.mu_markov
make_filter = _kernel.filter
make_interacting_filters = _kernel.interacting_filters
make_adaptive_filter = _kernel.adaptive_filter
learn_noises = _kernel.learn_noises
make_refinement = _kernel.refinement
linear_estimation_model = _kernel.linear_estimation_model
function_estimation_model = _kernel.function_estimation_model
tape_estimation_model = _kernel.tape_estimation_model
sensitivity = _kernel.sensitivity

NEXT = {
    "model": "check that the model is defined there, or bound its states",
    "singular": "give every measurement some noise, R > 0, or drop a measurement that repeats",
    "indefinite": "alpha >= n has no negative weight, with which this cannot happen",
    "range": "the model is unstable and unobserved there, or Q is far too large; scale the states",
}
ERRORS: dict[str, type[CompensatorError]] = {
    "model": FunctionFailedError,
    "singular": IllConditionedError,
    "indefinite": IllConditionedError,
    "range": DivergedError,
}


def estimation_failure(error: Exception, k: int) -> CompensatorError:
    """Return the InputError or DivergedError for a failure at step k."""
    if not isinstance(error, EstimationError):
        return FunctionFailedError(
            f"a function of the model failed at step {k}: {type(error).__name__}: {error}"
        )
    kind, words = error.args
    return ERRORS[kind](f"step {k}: {words}; {NEXT[kind]}.")
