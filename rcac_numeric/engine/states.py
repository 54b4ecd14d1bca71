"""What a controller or a whole loop carries from step to step, to be saved and restored exactly."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.values import Value


@dataclass(frozen=True, eq=False)
class SavedState(Value):
    """The state of a controller, or of controller, actuator and plant together, after k steps.

    Attributes
    ----------
    kind : {"controller", "loop"}
    k : int
        Number of steps taken.
    values : array
        Every number of the state; integers as their bits.
    fingerprint : str
        Of the settings that the state belongs to; it can be restored into no others.

    Examples
    --------
    >>> from rcac_numeric import UD, Controller, ControllerSettings, TargetModel, iir
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=1), target=TargetModel([0, 1]), update=UD(R_theta=1))
    >>> first, second = Controller(settings), Controller(settings)
    >>> for k in range(10):
    ...     _ = first.step(y=k % 3, z=k % 2)
    >>> second.restore(first.state)
    >>> bool((first.step(1, 1) == second.step(1, 1)).all())
    True
    """

    kind: str
    k: int
    values: Array = field(repr=False)
    fingerprint: str = field(repr=False)

    def save(self, path: str | Path) -> None:
        """Write the state to a .npz file.

        Raises
        ------
        InputError
            Where the file cannot be written.
        """
        try:
            with Path(path).open("wb") as file:
                np.savez(
                    file,
                    kind=np.array(self.kind),
                    k=np.array(self.k),
                    # As integers, so that no reader can mistake or normalise a bit pattern.
                    bits=np.asarray(self.values).view(np.int64),
                    fingerprint=np.array(self.fingerprint),
                )
        except OSError as error:
            raise InputError(f"{path} cannot be written: {error.strerror or error}.") from None

    @classmethod
    def load(cls, path: str | Path) -> SavedState:
        """Read a state that `save` wrote."""
        try:
            with Path(path).open("rb") as file, np.load(file, allow_pickle=False) as data:
                bits = data["bits"]
                if bits.dtype != np.int64 or bits.ndim != 1:
                    raise ValueError(f"bits are of type {bits.dtype}, shape {bits.shape}")
                return cls(
                    str(data["kind"]),
                    int(data["k"]),
                    np.ascontiguousarray(bits).view(np.float64),
                    str(data["fingerprint"]),
                )
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error}.") from None
        # BadZipFile and zlib.error where it was cut or damaged, EOFError where it is empty,
        # TypeError where it is another kind of NumPy file.
        except (KeyError, ValueError, TypeError, EOFError, BadZipFile, zlib.error) as error:
            raise InputError(f"{path} holds no saved state: {error}.") from None

    def restore_into(self, compiled: Any, kind: str, fingerprint: str) -> None:
        """Put the state into a compiled object; raise where it does not belong there."""
        if self.kind != kind:
            raise InputError(f"a {kind} cannot be restored from the state of a {self.kind}.")
        if self.fingerprint != fingerprint:
            raise InputError(
                f"the state belongs to a {kind} with other settings (fingerprint "
                f"{self.fingerprint}) than this one ({fingerprint}). Restore it with the settings "
                "that it was saved with."
            )
        values = self.values
        if not (isinstance(values, np.ndarray) and values.dtype == np.float64 and values.ndim == 1):
            raise InputError(
                f"the values of the state are a {type(values).__name__} instead of a float64 "
                "array of one dimension; use what `state` or `SavedState.load` gave."
            )
        before = compiled.save()
        try:
            compiled.restore(values)
        except (ValueError, IndexError) as error:
            compiled.restore(before)
            raise InputError(f"the state of this {kind} is damaged: {error}.") from None


def saved_state(value: Any, name: str) -> SavedState:
    """`value` if it is a saved state."""
    if not isinstance(value, SavedState):
        raise InputError(f"{name} = {value!r} is not a SavedState.")
    return value
