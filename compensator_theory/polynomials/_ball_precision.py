"""The precision of python-flint's balls: one for the whole process, so one thread at a time."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

import flint

from compensator_theory.errors import BudgetError, InputError, PrecisionError
from compensator_theory.polynomials._budget import is_integer, repr_of


class _Turn:
    """A re-entrant lock, the thread whose turn it is, and the precision from before its turn."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.holder: int | None = None
        self.outside = flint.ctx.prec

    def start_anew(self) -> None:
        """Reset the lock in a child of `fork`, where the thread that held it does not exist."""
        if self.holder not in (None, threading.get_ident()):
            flint.ctx.prec = self.outside
            self.lock, self.holder = threading.RLock(), None


_turn = _Turn()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_turn.start_anew)


@contextmanager
def ball_precision(bits: int) -> Iterator[None]:
    """Compute with python-flint's balls at a precision that no other thread changes.

    python-flint has one precision, ``flint.ctx.prec``, for all threads, and no function that takes
    another. So everything in this project that computes with balls does it inside such a block,
    one thread at a time, and leaves the precision as it was. Blocks may be nested. A program that
    uses balls of python-flint in other threads needs the same blocks around them.

    Parameters
    ----------
    bits : int
        Of the midpoint of every ball that is computed inside.

    Raises
    ------
    InputError
        If `bits` is no integer of at least 2.
    PrecisionError
        At the end, if the precision is no longer `bits`: it was set outside of such a block, by
        another thread or by the code inside, and the results are unreliable.

    Examples
    --------
    >>> import flint
    >>> from compensator_theory import ball_precision
    >>> with ball_precision(128):
    ...     third = flint.arb(1) / 3
    >>> third.rel_accuracy_bits() >= 126
    True
    """
    if not is_integer(bits) or bits < 2:
        raise InputError(f"a precision of {repr_of(bits)} bits; give an integer of at least 2")
    with _turn.lock:
        before, holder = flint.ctx.prec, _turn.holder
        if holder is None:
            _turn.outside = before
        try:
            _turn.holder = threading.get_ident()
            flint.ctx.prec = bits
            yield
        except Exception:
            _require_unchanged(bits)  # it may be the reason
            raise
        else:
            _require_unchanged(bits)
        finally:
            flint.ctx.prec = before
            _turn.holder = holder


def _require_unchanged(bits: int) -> None:
    if flint.ctx.prec != bits:
        raise PrecisionError(
            f"python-flint's precision was {bits} bits when a computation with balls began, and "
            f"{flint.ctx.prec} when it ended: something set flint.ctx.prec meanwhile, which is one "
            "for all threads. Repeat the computation, and set the precision with "
            "compensator_theory.ball_precision, which waits for its turn"
        )


Answer = TypeVar("Answer")
MOST_BITS = 2**18
"""Largest precision of a decision in balls, or 64 times its initial one."""


def at_growing_precision(
    attempt: Callable[[int], Answer | None], bits: int, subject: str, most: int | None = None
) -> Answer:
    """Repeat a decision in balls at twice the precision until it succeeds.

    The only loop of this project that doubles a precision. Who calls it has a proof that small
    enough balls decide: the number whose sign is requested is not zero, as it is the value of a
    polynomial at a root of an irreducible one that does not divide it, or two roots are distinct,
    as they are those of coprime polynomials.
    """
    most = max(MOST_BITS, 64 * bits) if most is None else most
    while bits <= most:
        with ball_precision(bits):
            answer = attempt(bits)
        if answer is not None:
            return answer
        bits *= 2
    raise BudgetError(
        f"{subject} needs balls of more than {most} bits: two numbers lie too close together; "
        "give numbers of fewer digits"
    )
