"""User functions called by the kernel, and their exceptions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Failures:
    """Store of the first exception that a user function raised during a kernel call."""

    def __init__(self) -> None:
        self.error: Exception | None = None
        self.guards_something = False

    @property
    def words(self) -> str:
        """Return the exception as text; empty without an exception."""
        return "" if self.error is None else f"{type(self.error).__name__}: {self.error}"

    def guard(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Wrap `function`: an exception is stored and None is returned."""
        self.guards_something = True

        def guarded(*arguments: Any) -> Any:
            try:
                return function(*arguments)
            except Exception as error:
                self.error = self.error or error
                return None

        return guarded

    def take(self) -> Exception | None:
        """Return the exception and clear it."""
        error, self.error = self.error, None
        return error
