"""Saved states of controllers and loops, restored exactly."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._files import replacing
from rcac_numeric.arrays._untrusted import read_npz
from rcac_numeric.arrays._validation import instance_of, integer, number
from rcac_numeric.arrays._values import Value, fingerprint

_WORDS = re.compile(r"[a-z ]{1,40}")
_HEX = re.compile(r"[0-9a-f]{16}")


@dataclass(frozen=True, eq=False)
class SavedState(Value):
    """The state of a controller, or of controller, actuator and plant together, after k steps.

    Attributes
    ----------
    kind : {"controller", "loop", "filter", "refinement", "indirect controller"}
    k : int
        Number of steps taken.
    values : array
        Every number of the state; integers as their bits.
    fingerprint : str
        Of the settings that the state belongs to; it can be restored into no others.
    checksum : str
        Of all of this: a state that was changed is refused.
    scale : float
        The largest size of w and x_0 up to here, on which the divergence limit of a run that goes
        on depends, as that of the whole run does.

    Raises
    ------
    InputError
        Where one of them is of another kind.

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
    checksum: str = field(repr=False)
    scale: float = field(default=0.0, repr=False)

    def __post_init__(self) -> None:
        if not _WORDS.fullmatch(instance_of(self.kind, "kind", str)):
            raise InputError(f"kind = {self.kind!r:.60} is no kind of state.")
        integer(self.k, "k")
        for name in ("fingerprint", "checksum"):
            if not _HEX.fullmatch(instance_of(getattr(self, name), name, str)):
                raise InputError(f"{name} = {getattr(self, name)!r:.60} is no fingerprint.")
        if number(self.scale, "scale") < 0:
            raise InputError(f"scale = {self.scale} must not be negative.")

    @classmethod
    def of_values(cls, kind: str, k: int, values: Array, of: str, scale: float = 0.0) -> SavedState:
        """Return the state of a compiled object whose settings have the fingerprint `of`.

        Most states are never used: the checksum is computed on first access, from immutable
        bytes.
        """
        state = object.__new__(cls)
        numbers = np.frombuffer(values.tobytes())
        state.__dict__.update(kind=kind, k=k, values=numbers, fingerprint=of, scale=scale)
        return state

    def __getattr__(self, name: str) -> str:
        """Compute the checksum on first access."""
        if name != "checksum" or "scale" not in self.__dict__:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        of = self.kind, self.k, self.values, self.fingerprint, self.scale
        return str(self.__dict__.setdefault(name, _checksum(*of)))

    def __getstate__(self) -> dict[str, Any]:
        """Include the checksum, so that a change of the pickle is detected."""
        return {"checksum": self.checksum, **self.__dict__}

    def save(self, path: str | Path) -> None:
        """Write the state to a .npz file; an older file of that name stays whole until then.

        Raises
        ------
        InputError
            Where the file cannot be written.
        """
        with replacing(path) as file:
            np.savez(
                file,
                kind=np.array(self.kind),
                k=np.array(self.k),
                # As integers, so that no reader changes a bit pattern.
                bits=np.asarray(self.values).view(np.int64),
                fingerprint=np.array(self.fingerprint),
                checksum=np.array(self.checksum),
                scale=np.array(self.scale),
            )

    @classmethod
    def load(cls, path: str | Path) -> SavedState:
        """Read a state that `save` wrote.

        Raises
        ------
        InputError
            Where the file cannot be read, holds no saved state or more than is read, or is damaged.
        """
        try:
            data = read_npz(Path(path))
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror or error}.") from None
        except InputError as error:
            raise InputError(f"{path} holds no saved state: {error}") from None
        try:
            bits = data["bits"]
            if bits.dtype != np.int64 or bits.ndim != 1:
                raise ValueError(f"bits are of type {bits.dtype}, shape {bits.shape}")
            values = np.ascontiguousarray(bits).view(np.float64)
            kind, of, checksum = (_text(data[n], n) for n in ("kind", "fingerprint", "checksum"))
            k = _entry(data["k"], "k", "i")
            scale = _entry(data["scale"], "scale", "f") if "scale" in data else 0.0
            state = cls(kind, k, values, of, checksum, scale)
        except KeyError as error:
            raise InputError(f"{path} holds no saved state: it has no {error}.") from None
        except ValueError as error:
            raise InputError(f"{path} holds no saved state: {str(error).rstrip('.')}.") from None
        if checksum != _checksum(kind, k, values, of, scale):
            raise InputError(f"{path} is damaged: its checksum is not that of its contents.")
        return state

    def restored(
        self,
        kind: str,
        of: str,
        *,
        save: Callable[[], Array],
        restore: Callable[[Array], None],
        steps: Callable[[], int],
    ) -> None:
        """Restore the state into an object; on an error the object is unchanged.

        Parameters
        ----------
        kind, of : str
            What the object is, and the fingerprint of its settings.
        save, restore : functions
            Its numbers, and from them; ValueError or IndexError where they are something else.
        steps : function
            How many steps it has taken.
        """
        if self.kind != kind:
            raise InputError(f"a {kind} cannot be restored from the state of a {self.kind}.")
        if self.fingerprint != of:
            raise InputError(
                f"the state belongs to a {kind} with other settings (fingerprint "
                f"{self.fingerprint}) than this one ({of}). Restore it with the settings "
                "that it was saved with."
            )
        values = self.values
        if not (isinstance(values, np.ndarray) and values.dtype == np.float64 and values.ndim == 1):
            raise InputError(
                f"the values of the state are a {type(values).__name__} instead of a float64 "
                "array of one dimension; use what `state` or `SavedState.load` gave."
            )
        if self.checksum != _checksum(kind, self.k, values, of, self.scale):
            raise InputError(
                f"the state of this {kind} is damaged: it was changed after it was saved."
            )
        before = save()
        try:
            restore(values)
            if steps() != self.k:
                raise ValueError(f"its header has step {self.k}, its contents step {steps()}")
        except (ValueError, IndexError) as error:
            restore(before)
            raise InputError(f"the state of this {kind} is damaged: {error}.") from None


def _entry(array: Array, name: str, kind: str) -> Any:
    """Return the single entry of an array of a NumPy kind."""
    if array.ndim or array.dtype.kind != kind:
        raise ValueError(f"{name} is of type {array.dtype}, shape {array.shape}")
    return array.item()


def _text(array: Array, name: str) -> str:
    return str(_entry(array, name, "U"))


def _checksum(kind: str, k: int, values: Array, of: str, scale: float) -> str:
    words = (kind, k, values, of)
    return fingerprint((*words, scale) if scale else words)  # files of older versions have no scale


def saved_state(value: object, name: str) -> SavedState:
    """Return `value` if it is a SavedState, else raise InputError."""
    if not isinstance(value, SavedState):
        raise InputError(f"{name} = {value!r} is not a SavedState.")
    return value
