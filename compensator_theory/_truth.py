"""The truth value of a result: its yes-or-no answer, otherwise an error."""

from __future__ import annotations

from typing import ClassVar

from compensator_theory.errors import InputError


class Truth:
    """Base of results; `_ANSWER` names the attribute that is the yes or no, True, False or None."""

    _ANSWER: ClassVar[str] = ""

    def __bool__(self) -> bool:
        kind = type(self)
        if not kind._ANSWER:
            ask = " or ".join(f".{name}" for name in _questions(kind)) or "one of its attributes"
            raise InputError(
                f"{kind.__name__} has no truth value; test {ask}, or write `is not None`"
            )
        answer = getattr(self, kind._ANSWER)
        if answer is None:
            first = str(self).split("\n", maxsplit=1)[0]
            raise InputError(
                f"{kind.__name__} is undecided, and has no truth value: {first}; .{kind._ANSWER} "
                "is None"
            )
        return bool(answer)


def _questions(kind: type) -> list[str]:
    """Names of the boolean attributes."""
    names = (name for name in dir(kind) if name.startswith(("is_", "has_", "agrees", "holds")))
    return sorted(name for name in names if not callable(getattr(kind, name, None)))
