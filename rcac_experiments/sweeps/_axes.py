"""The axes of a study: settings or plant parameters, with their values."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import attrs
import numpy as np

from compensator_theory.errors import InputError
from rcac_experiments.sweeps._canonical import canonical_json, plain
from rcac_numeric.arrays._validation import instance_of, integer, items, one_of, real_array
from rcac_numeric.arrays._values import Value

# Values of one axis. They are all held at once, unlike the runs.
LARGEST_AXIS = 10**6
DISTRIBUTIONS = ("uniform", "log_uniform", "normal")
# What the table that is read back calls its own columns.
RESERVED = ("run", "cell", "repetition", "outcome", "failure", "signals_digest")


@attrs.frozen(eq=False, slots=False)
class Axis(Value):
    """One axis of a study: a setting or parameter, and its values.

    Parameters
    ----------
    name : str
        The name in tables and pictures.
    values : sequence
        Numbers, texts, truth values, or lists and tables of them; no two alike.
    sets : str, optional
        Where the value goes: a dotted path into the experiment file, such as
        "controller.R_theta" or "plant.changes.0.delay"; the name where it is left out, as for a
        study of a function.

    Examples
    --------
    >>> from rcac_experiments.sweeps import Axis
    >>> Axis("R_theta", [1e-4, 1e-2, 1], sets="controller.R_theta")
    Axis(R_theta: 3 values of controller.R_theta)
    """

    name: str
    values: Sequence[Any]
    sets: str = ""

    def __attrs_post_init__(self) -> None:
        name = _name(self.name)
        read = tuple(map(plain, items(self.values, f"the values of axis {name!r}")))
        if not read:
            raise InputError(f"the axis {name!r} has no values; give at least one.")
        if len(read) > LARGEST_AXIS:
            raise too_many(name, len(read))
        numbers: dict[str, int] = {}
        for number, value in enumerate(read):
            text = canonical_json(value)
            if text in numbers:
                raise InputError(f"the axis {name!r} has the value {value!r} twice.")
            numbers[text] = number
        object.__setattr__(self, "values", read)
        object.__setattr__(self, "sets", instance_of(self.sets, "sets", str) or name)

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        return f"Axis({self.name}: {len(self)} value{'s' * (len(self) > 1)} of {self.sets})"


@attrs.frozen(eq=False, slots=False)
class RandomAxis(Value):
    """One random axis: values drawn from the seed of the study and the name.

    More draws go on where fewer ended, so a study can be extended.

    Parameters
    ----------
    name, sets : str
        As for `Axis`.
    distribution : {"uniform", "log_uniform", "normal"}
    parameters : pair of floats
        Least and largest value; mean and standard deviation.
    draws : int

    Examples
    --------
    >>> from rcac_experiments.sweeps import RandomAxis
    >>> phase = RandomAxis("phase", "uniform", [0, 6.28], draws=3, sets="signals.r.phase")
    >>> phase.drawn(seed=1).values == phase.drawn(seed=1).values
    True
    """

    name: str
    distribution: str
    parameters: Sequence[float]
    draws: int
    sets: str = ""

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        name, distribution = _name(self.name), self.distribution
        one_of(distribution, "distribution", DISTRIBUTIONS)
        low, high = pair(self.parameters, f"{distribution} of axis {name!r}")
        if distribution != "normal" and not low < high:
            raise InputError(f"the axis {name!r} has {distribution} = [{low}, {high}]; give the "
                             "least value first.")  # fmt: skip
        if distribution == "log_uniform" and low <= 0:
            raise InputError(f"the axis {name!r}: log_uniform needs positive numbers, not {low}.")
        if distribution == "normal" and high <= 0:
            raise InputError(f"the axis {name!r}: the standard deviation {high} must be positive.")
        set_("parameters", (low, high))
        set_("draws", integer(self.draws, "draws", at_least=1))
        if self.draws > LARGEST_AXIS:
            raise too_many(name, self.draws)
        set_("sets", instance_of(self.sets, "sets", str) or name)

    def drawn(self, seed: int) -> Axis:
        """The axis with its values."""
        key = hashlib.blake2b(self.name.encode(), digest_size=16).digest()
        words = tuple(int(word) for word in np.frombuffer(key, "<u4"))
        rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=words))
        low, high = self.parameters
        if self.distribution == "uniform":
            values = rng.uniform(low, high, self.draws)
        elif self.distribution == "normal":
            values = rng.normal(low, high, self.draws)
        else:
            values = np.exp(rng.uniform(math.log(low), math.log(high), self.draws))
        return Axis(self.name, values.tolist(), self.sets)


def pair(value: Any, name: str) -> tuple[float, float]:
    """Two numbers."""
    array = real_array(value, name)
    if array.shape != (2,):
        raise InputError(f"{name} = {value!r} must be two numbers.")
    return float(array[0]), float(array[1])


def too_many(name: str, count: int) -> InputError:
    """That an axis is too long to be meant."""
    return InputError(
        f"the axis {name!r} has {count} values; at most {LARGEST_AXIS} are allowed. Use fewer, "
        "or more repetitions."
    )


def _name(name: str) -> str:
    instance_of(name, "the name of an axis", str)
    if not name.isidentifier() or name.lower() in RESERVED:
        raise InputError(
            f"an axis cannot be called {name!r}; use letters, digits and underscores, and none of "
            f"{', '.join(RESERVED)}."
        )
    return name
