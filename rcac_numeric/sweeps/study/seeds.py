"""Random numbers of a run, from the seed of the study and the run's own coordinates alone."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.signals.signal import Signal
from rcac_numeric.sweeps.study.canonical import canonical_json

# A channel of w has its number; what is drawn beside the channels has these.
PERTURBATION, WHOLE_RUN = 2**32 - 1, 2**32 - 2


def words_of(by_path: dict[str, Any]) -> tuple[int, ...]:
    """Coordinates as four integers below 2^32: the same however many other values there are.

    Examples
    --------
    >>> from rcac_numeric.sweeps.study.seeds import words_of
    >>> words_of({"a": 1, "b": 2.0}) == words_of({"b": 2, "a": 1.0}) != words_of({"a": 1})
    True
    """
    key = hashlib.blake2b(canonical_json(by_path).encode(), digest_size=16).digest()
    return tuple(int(word) for word in np.frombuffer(key, "<u4"))


def generator(
    seed: int, words: tuple[int, ...], repetition: int, channel: int
) -> np.random.Generator:
    """A generator of its own for one channel of one run, independent of all others."""
    key = (*words, repetition, channel)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=key)))


def exogenous_input(
    signals: tuple[Signal, ...],
    steps: int,
    seed: int,
    words: tuple[int, ...],
    repetition: int,
    perturbation: float = 0.0,
) -> Array:
    """The exogenous input w of one run, shape (steps, number of signals).

    With a perturbation, all repetitions but the first are multiplied by
    1 + perturbation * (standard normal).
    """
    w = np.empty((steps, len(signals)))
    for channel, signal in enumerate(signals):
        w[:, channel] = signal.samples(steps, generator(seed, words, repetition, channel))
    if perturbation and repetition:
        rng = generator(seed, words, repetition, PERTURBATION)
        w *= 1 + perturbation * rng.standard_normal(w.shape)
    return w
