"""Functions of the user that the kernel calls, and what becomes of their exceptions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Failures:
    """Holds the first exception that a user's function raised while the kernel ran."""

    def __init__(self) -> None:
        self.error: Exception | None = None
        self.guards_something = False

    @property
    def words(self) -> str:
        """The exception in words; empty where there is none."""
        return "" if self.error is None else f"{type(self.error).__name__}: {self.error}"

    def guard(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """`function`, but an exception is kept here and None returned."""
        self.guards_something = True

        def guarded(*arguments: Any) -> Any:
            try:
                return function(*arguments)
            except Exception as error:
                self.error = self.error or error
                return None

        return guarded

    def take(self) -> Exception | None:
        """The exception, which is forgotten here."""
        error, self.error = self.error, None
        return error
