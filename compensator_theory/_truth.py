"""The truth value of a result: its answer where it answers yes or no, and else none."""

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
                f"{kind.__name__} is no answer to a yes-or-no question, and has no truth value; "
                f"ask {ask}, or write `is not None`"
            )
        answer = getattr(self, kind._ANSWER)
        if answer is None:
            first = str(self).split("\n", maxsplit=1)[0]
            raise InputError(
                f"{kind.__name__} is undecided, and has no truth value: {first}; look at "
                f".{kind._ANSWER}, which is None"
            )
        return bool(answer)


def _questions(kind: type) -> list[str]:
    """Attributes that answer yes or no."""
    names = (name for name in dir(kind) if name.startswith(("is_", "has_", "agrees", "holds")))
    return sorted(name for name in names if not callable(getattr(kind, name, None)))
