"""Changes of a running controller: requests and applied changes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    instance_of,
    one_of,
    optional_array_like,
    reads,
    real_array,
    with_checks,
)
from rcac_numeric.arrays._values import Result, Value
from rcac_numeric.arrays._wording import printable
from rcac_numeric.controllers._forgetting import forgetting_factor
from rcac_numeric.controllers._weights import SignalWeight
from rcac_numeric.targets._model import TargetModel

COVARIANCES = ("blend", "keep", "reset", "replay")
NUMBERS = ("lambda_", "R_z", "R_u", "R_u_unfiltered")
LiveWeight = float | Array | SignalWeight


def _live_weight(value: ArrayLike | SignalWeight | None) -> LiveWeight | None:
    """Typing stub: argument type of a weight."""
    return cast(LiveWeight, value)


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class ControllerChange(Value):
    """A requested change of a running controller; None keeps a setting.

    Parameters
    ----------
    target : TargetModel, optional
        G_f from the next step on. The filter's history is what the new G_f makes of the stored
        signals, and theta is kept.
    covariance : {"blend", "keep", "reset", "replay"}
        What becomes of P with a new target, see `Controller.set_target`.
    lambda_ : float, optional
        Forgetting factor, in (0, 1].
    R_z, R_u : float, array of shape (l_z, l_z), or SignalWeight, optional
    R_u_unfiltered : float or array of shape (l_u, l_u), optional

    Raises
    ------
    InputError
        Where a part cannot be read, or nothing is to change.

    Examples
    --------
    >>> from rcac_numeric import ControllerChange
    >>> ControllerChange(lambda_=0.99, R_u=0.1)
    ControllerChange(lambda_=0.99, R_u=0.1)
    """

    target: TargetModel | None = attrs.field(
        default=None, metadata=reads(instance_of, kind=TargetModel, optional=True)
    )
    covariance: str = attrs.field(
        default="blend", kw_only=True, metadata=reads(one_of, choices=COVARIANCES)
    )
    lambda_: float | None = attrs.field(
        default=None, kw_only=True, metadata=reads(forgetting_factor, optional=True)
    )
    R_z: LiveWeight | None = attrs.field(default=None, kw_only=True, converter=_live_weight)
    R_u: LiveWeight | None = attrs.field(default=None, kw_only=True, converter=_live_weight)
    R_u_unfiltered: float | Array | None = attrs.field(
        default=None, kw_only=True, converter=optional_array_like
    )

    def __attrs_post_init__(self) -> None:
        if isinstance(self.R_u_unfiltered, SignalWeight):
            raise InputError("R_u_unfiltered must be constant; give a number or a matrix.")
        for name in ("R_z", "R_u", "R_u_unfiltered"):
            object.__setattr__(self, name, _weight(getattr(self, name), name))
        if self.target is None and all(getattr(self, name) is None for name in NUMBERS):
            raise InputError(
                "the change is empty: give target, lambda_, R_z, R_u or R_u_unfiltered."
            )

    def __repr__(self) -> str:
        words = [f"{self.target!r}, covariance={self.covariance!r}"] if self.target else []
        words += [
            f"{name}=<{value.shape[0]} x {value.shape[1]}>"
            if isinstance(value, np.ndarray)
            else f"{name}={value!r}"
            for name in NUMBERS
            if (value := getattr(self, name)) is not None
        ]
        return f"ControllerChange({', '.join(words)})"


@dataclass(frozen=True, eq=False)
class AppliedChange(Result):
    """An applied change of a running controller, with its effect.

    Attributes
    ----------
    k : int
        The first step with it.
    change : ControllerChange
        The requested change.
    covariance : str
        Treatment of P: as requested, or "reset" in place of "blend" where the number of NMP
        zeros of the target model changed or nothing of the past was left; empty without a target.
    distance : float
        How far the filtered signals moved over the last 64 steps, ``sum |new - old|^2`` over
        ``sum |new|^2``; 0 without a target.
    evidence : str
        The reason that its author gave, or empty.
    """

    k: int
    change: ControllerChange
    covariance: str = ""
    distance: float = 0.0
    evidence: str = ""

    def __str__(self) -> str:
        because = f": {printable(self.evidence)}" if self.evidence else ""
        return f"step {self.k}, {self.change!r}{because}"


def nmp_zero_count(numerator: Array) -> int | None:
    """Return the number of zeros of G_f outside the unit circle; None if G_f is not square.

    Of a square G_f those of det N_f, in float64: a count that decides about P, not about a claim.
    """
    l_z, l_u = numerator.shape[1:]
    if l_z != l_u:
        return None
    determinant = numerator[:, 0, 0] if l_z == 1 else _determinant(numerator)
    nonzero = determinant.nonzero()[0]
    if len(nonzero) < 2:
        return 0
    inner = determinant[nonzero[0] : nonzero[-1] + 1]
    if len(inner) == 2:
        return int(abs(inner[1]) > abs(inner[0]))
    return int(np.count_nonzero(np.abs(np.roots(inner)) > 1))


def _determinant(numerator: Array) -> Array:
    """Return the coefficients of det N_f in powers of q^{-1}, without rounding errors."""
    size = numerator.shape[1] * (len(numerator) - 1) + 1
    values = np.linalg.det(np.fft.fft(numerator, n=size, axis=0))
    coefficients = np.fft.ifft(values).real
    coefficients[np.abs(coefficients) <= 1e-12 * np.abs(coefficients).max(initial=0.0)] = 0.0
    return np.asarray(coefficients)


def _weight(value: ArrayLike | SignalWeight | None, name: str) -> LiveWeight | None:
    if value is None or isinstance(value, SignalWeight):
        return value
    if callable(value):
        raise InputError(
            f"{name} is a function; a function cannot be saved with a run. While the controller "
            "runs, use a number, a matrix or a SignalWeight."
        )
    array = real_array(value, name)
    return array if array.ndim else float(array)
