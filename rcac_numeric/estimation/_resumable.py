"""Step-by-step objects that can be saved and continue bit for bit."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar, Generic, TypeVar

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import fingerprint, html_table
from rcac_numeric.engine._states import SavedState, saved_state

S = TypeVar("S")


class Resumable(ABC, Generic[S]):
    """An object with settings and a state; copies and pickles are independent of it."""

    kind: ClassVar[str]

    def __init__(self, settings: S) -> None:
        self.settings = settings

    @property
    @abstractmethod
    def k(self) -> int:
        """Number of steps taken."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}(k={self.k}, {type(self.settings).__name__})"

    def _repr_html_(self) -> str:
        """The progress and the settings as HTML for a notebook."""
        return html_table(
            type(self).__name__, [("k", str(self.k)), ("settings", str(self.settings))]
        )

    @abstractmethod
    def save(self) -> Array:
        """Every number that later steps depend on, in one dimension; `state` is for users."""

    @abstractmethod
    def take_up(self, values: Array) -> None:
        """Continue from a saved state; ValueError if it does not fit."""

    @property
    def state(self) -> SavedState:
        """Everything that later steps depend on, beside the settings."""
        return SavedState.of_values(self.kind, self.k, self.save(), fingerprint(self.settings))

    def restore(self, state: SavedState) -> None:
        """Go back, or forward, to a saved state of an object with the same settings."""
        saved_state(state, "state").restored(
            self.kind, fingerprint(self.settings),
            save=self.save, restore=self.take_up, steps=lambda: self.k,
        )  # fmt: skip

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (type(self), self.settings, self.state)


def _rebuilt(kind: type[Resumable[Any]], settings: Any, state: SavedState) -> Resumable[Any]:
    resumable = kind(settings)
    resumable.restore(state)
    return resumable
