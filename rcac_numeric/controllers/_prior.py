"""R_theta as an equivalent number of samples."""

from __future__ import annotations

from typing import cast

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import number, reads, real_array, with_checks
from rcac_numeric.arrays._values import Value


def _signal_like(value: ArrayLike) -> Array:
    """Typing stub: argument type of a signal."""
    return cast(Array, value)


def _optional_signal_like(value: ArrayLike | None) -> Array | None:
    """Typing stub: argument type of an optional signal."""
    return cast(Array, value)


def _samples(value: object, name: str) -> float:
    samples = number(value, name)
    if not samples > 0:
        raise InputError(f"{name} = {samples:g} must be positive: the prior weight in samples.")
    return samples


def _signal(value: ArrayLike, name: str) -> Array:
    """Converter: return the size of each component, or a record with one row a step."""
    array = real_array(value, name)
    array = array.reshape(-1, 1) if array.ndim == 1 and array.size > MOST else array
    if array.ndim > 2 or not array.size or not array.any():
        raise InputError(
            f"{name} is neither the size of a signal nor a record of it: give its root mean "
            "square, one for each component, or the record, shape (steps, components)."
        )
    return array if array.ndim == 2 else np.abs(np.atleast_1d(array))


MOST = 16  # a longer list is a record of one signal, not sizes of components


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class PriorSamples(Value):
    """Replaces R_theta: theta(0) has the weight of that many samples, in any units.

        R_theta = samples * mean(Phi_f' Phi_f)

    of a record of the loop, or of signals of this size, white and independent, of which u, where it
    is not given, is what moves z through G_f by the size of y. `ControllerSettings`, which knows
    structure and target model, puts the matrix in its place.

    Parameters
    ----------
    samples : float
        For a theta(0) that is a controller: 100 where little is known of the signals, 1000 where
        they are as recorded; 1 lets the first ones decide. From theta(0) = 0 see `cold_start`.
    y : float, array of sizes, or record of shape (steps,) or (steps, l_y)
        Root mean square of each measurement; or a record of the loop with theta(0).
    u, r : the same, optional
        Of each control, and of each command that the structure reads. With a record of y that of
        u is needed, too.

    Raises
    ------
    InputError
        Where a size is zero, or a record has another length than that of y.

    Examples
    --------
    >>> from rcac_numeric import UD, ControllerSettings, PriorSamples, TargetModel, iir
    >>> prior = PriorSamples(100, y=0.5)
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=1), target=TargetModel([0, 2]), update=UD(R_theta=prior))
    >>> settings.update.R_theta.round(1)  # of u, which is 0.25 of G_f, and of y
    array([[ 25.,   0.],
           [  0., 100.]])
    """

    samples: float = attrs.field(metadata=reads(_samples))
    y: Array = attrs.field(converter=_signal_like, metadata=reads(_signal))
    u: Array | None = attrs.field(
        default=None, converter=_optional_signal_like, metadata=reads(_signal, optional=True)
    )
    r: Array | None = attrs.field(
        default=None, converter=_optional_signal_like, metadata=reads(_signal, optional=True)
    )

    def __attrs_post_init__(self) -> None:
        if not self.is_record:
            return
        sizes = {"u": self.u, "r": self.r}
        for name, signal in sizes.items():
            if signal is None and name == "r":
                continue
            if signal is None or len(signal) != len(self.y) or signal.ndim != 2:
                raise InputError(
                    f"y is a record of {len(self.y)} steps, and {name} is not: give that of the "
                    "same steps, or the sizes of both."
                )

    @property
    def is_record(self) -> bool:
        """Whether y is a record of the loop, not a size."""
        return self.y.ndim == 2
