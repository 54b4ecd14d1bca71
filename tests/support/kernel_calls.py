"""Calls of the compiled module that may be refused, and how many there were."""

from collections import Counter

from rcac_numeric.compiled import _kernel

REFUSALS = (ValueError, TypeError, IndexError, OverflowError, _kernel.EstimationError)
calls: Counter[str] = Counter()  # "answered", "refused"


def attempt(function, *arguments, **options):
    """What the kernel answers, or None where it refuses in one of its ways."""
    try:
        answer = function(*arguments, **options)
    except REFUSALS:
        calls["refused"] += 1
        return None
    calls["answered"] += 1
    return answer
