"""RCMR over a whole record."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import DivergedError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import signal_array
from rcac_numeric.arrays.values import Value
from rcac_numeric.engine.compiled.estimators import EstimationError
from rcac_numeric.estimation.local_observability import UnidentifiableWarning
from rcac_numeric.estimation.refinement.compiled import compiled_refinement
from rcac_numeric.estimation.refinement.evidence import Evidence, evidence
from rcac_numeric.estimation.refinement.settings import RCMR


@dataclass(frozen=True, eq=False)
class RefinementRun(Value):
    """What RCMR made of a record.

    Attributes
    ----------
    settings : RCMR
    theta : array, shape (steps, l_theta)
        theta(k).
    z : array, shape (steps, l_y)
        C x^(k) - y(k).
    u : array, shape (steps, l_u)
        The subsystem's output u^(k).
    P : array, shape (l_theta, l_theta)
        At the end.
    evidence : Evidence
        Which directions of theta the record determines.
    guard_count : int
        Updates that rounding decided.
    """

    settings: RCMR
    theta: Array
    z: Array
    u: Array
    P: Array
    evidence: Evidence
    guard_count: int


def refine(settings: RCMR, w: ArrayLike, y: ArrayLike, x: ArrayLike | None = None) -> RefinementRun:
    """Refine a model with a record of inputs and measurements.

    Parameters
    ----------
    settings : RCMR
    w : array, shape (steps, l_w)
        The known input; a 1-D array is one signal.
    y : array, shape (steps, l_y)
        The measurements.
    x : array, shape (steps, n), optional
        Measured states, for a one-step predictor.

    Returns
    -------
    RefinementRun

    Raises
    ------
    InputError
        Where shapes do not fit or an entry is not finite.
    DivergedError
        Where the free-running model left the range of float64.

    Warns
    -----
    UnidentifiableWarning
        Where the record does not determine every coefficient.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.estimation import RCMR, refine
    >>> w, x = np.random.default_rng(1).standard_normal(300), [0.0]
    >>> for input in w[:-1]:
    ...     x.append((0.5 + 0.3) * x[-1] + input)
    >>> run = refine(RCMR(A=0.5, B=1, D_1=1, C=1, E_1=1, delays=(1,)), w, x)
    >>> run.theta[-1].round(3)
    array([0.3])
    """
    run = refined_record(settings, w, y, x)
    if len(run.evidence.undetermined):
        warnings.warn(str(run.evidence), UnidentifiableWarning, stacklevel=2)
    return run


def refined_record(
    settings: RCMR, w: ArrayLike, y: ArrayLike, x: ArrayLike | None = None
) -> RefinementRun:
    """As `refine`, without the warning: for who reads `evidence`."""
    kernel = compiled_refinement(settings)
    outputs = signal_array(y, "y", settings.l_y)
    steps = len(outputs)
    inputs = signal_array(w, "w", settings.l_w, steps)
    states = np.zeros(0) if x is None else signal_array(x, "x", settings.n, steps)
    theta = np.zeros((steps, settings.l_theta))
    z, u = np.zeros((steps, settings.l_y)), np.zeros((steps, settings.l_u))
    try:
        kernel.run(inputs, outputs, states, theta, z, u)
    except EstimationError:
        raise DivergedError(
            f"the refined model left the range of float64 at step {kernel.k}: run freely, it went "
            "unstable. Give the states x that were measured, use a smaller beta, or other delays."
        ) from None
    P = np.asarray(kernel.P)
    found = evidence(settings, P, kernel.k)
    return RefinementRun(settings, theta, z, u, P, found, kernel.guard_count)
