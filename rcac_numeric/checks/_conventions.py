"""The conventions of u = Phi theta in which other programs differ from ours."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Literal

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Result, replaced
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._structure import Structure, Tap

Signal = Literal["y", "z", "r - y", "r + y"]
Stacking = Literal["columns", "rows", "rows of each lag"]
SIGNALS: tuple[Signal, ...] = ("y", "z", "r - y", "r + y")
NO_YES = (False, True)
STACKINGS: tuple[Stacking, ...] = ("columns", "rows", "rows of each lag")


@dataclass(frozen=True)
class Convention(Result):
    """The order and signs of theta and Phi in another program; by default those used here.

    Ours is u(k) = Phi(k) theta(k), Phi(k) = [u(k-1) ... u(k-n_c)  y(k-1) ... y(k-n_c)] for one
    input and one output, (2.29)-(2.30). A text names what differs, separated by commas, such as
    "-y, y first"; "ours" says that nothing does.

    Attributes
    ----------
    negative_u : bool
        "-u": theta acts on -u(k-i), as the denominator D_c is written.
    negative_y : bool
        "-y": theta acts on -y, negative feedback. With "-u" too, u = -Phi theta.
    signal : {"y", "z", "r - y", "r + y"}
        "z for y" and so on: the signal that the controller reads in place of the logged y.
    y_first : bool
        "y first": the coefficients of y stand before those of u.
    is_interleaved : bool
        "interleaved": u(k-1), y(k-1), u(k-2), y(k-2), ...
    oldest_first : bool
        "oldest first": u(k-n_c), ..., u(k-1).
    by_component : bool
        "by component": all lags of u_1, then those of u_2; for several signals.
    stacking : {"columns", "rows", "rows of each lag"}
        "by rows": all coefficients of the first input, then those of the second; "lags by rows":
        the matrix of each lag by rows; for several inputs.
    own_u : bool
        "own u": Phi holds the u that the controller computed, before the limits of the actuator.

    Examples
    --------
    >>> from rcac_numeric import iir
    >>> from rcac_numeric.checks._conventions import convention_of
    >>> convention = convention_of("y first, -y")
    >>> str(convention), convention.positions(iir(n_c=2)).tolist()
    ('-y, y first', [2, 3, 0, 1])
    >>> convention.signs(iir(n_c=2)).tolist()
    [1.0, 1.0, -1.0, -1.0]
    """

    negative_u: bool = False
    negative_y: bool = False
    signal: Signal = "y"
    y_first: bool = False
    is_interleaved: bool = False
    oldest_first: bool = False
    by_component: bool = False
    stacking: Stacking = "columns"
    own_u: bool = False

    def __str__(self) -> str:
        return ", ".join(word for word in WORDS if _has(self, word)) or NO_DIFFERENCE

    @property
    def description(self) -> str:
        """The convention in words."""
        phrases = [PHRASES[word] for word in WORDS if _has(self, word)]
        if self.negative_u and self.negative_y:
            phrases = ["u = -Phi theta", *phrases[2:]]
        return "; ".join(phrases) or "u = Phi theta as in this package"

    def positions(self, structure: Structure) -> Array:
        """Indices of our coefficients in theta of the other program; shape (l_theta,)."""
        l_u = structure.l_u
        lags = self._lags(structure)
        order: list[tuple[int, int]] = []  # (tap, component of u) in the other program's order
        if self.stacking == "rows":
            order = [(tap, i) for i in range(l_u) for lag in lags for tap in lag]
        elif self.stacking == "rows of each lag":
            order = [(tap, i) for lag in lags for i in range(l_u) for tap in lag]
        else:
            order = [(tap, i) for lag in lags for tap in lag for i in range(l_u)]
        positions = np.empty(structure.l_theta, dtype=int)
        for position, (tap, i) in enumerate(order):
            positions[tap * l_u + i] = position
        return positions

    def signs(self, structure: Structure) -> Array:
        """The sign of each coefficient, in our order."""
        past = {"u": self.negative_u, "y": self.negative_y, "derived": self.negative_y}
        signs = [-1.0 if past.get(tap.signal, False) else 1.0 for tap in structure.taps]
        return np.repeat(signs, structure.l_u)

    def theta(self, theta: Array, structure: Structure) -> Array:
        """The coefficients in our order and with our signs."""
        if theta.shape[-1] != structure.l_theta:
            return theta  # refused by require_fit, with the sizes
        return np.asarray(theta[..., self.positions(structure)] * self.signs(structure))

    def compensator(self, compensator: Compensator) -> Compensator:
        """The compensator that acts as one with these signs does.

        Raises
        ------
        InputError
            Where the convention is about the order of theta, which a compensator has not.
        """
        signs = Convention(self.negative_u, self.negative_y, self.signal)
        if self != signs:
            raise InputError(
                f"convention = {str(self)!r} is about theta; a compensator has the words "
                '"-u", "-y", "z for y", "r - y for y" and "r + y for y".'
            )
        P, Q = compensator.past_u, compensator.past_y
        return replaced(
            compensator, past_u=-P if self.negative_u else P, past_y=-Q if self.negative_y else Q
        )

    def _lags(self, structure: Structure) -> list[list[int]]:
        """The indices of the taps, lag by lag, in the other program's order."""
        groups: dict[str, list[int]] = {}
        for index, tap in enumerate(structure.taps):
            groups.setdefault(tap.signal, []).append(index)
        names = sorted(groups, key=lambda name: name == "u") if self.y_first else list(groups)
        blocks = {name: self._block(structure.taps, groups[name]) for name in names}
        if not self.is_interleaved:
            return [lag for name in names for lag in blocks[name]]
        longest = max(map(len, blocks.values()))
        return [blocks[n][i] for i in range(longest) for n in names if i < len(blocks[n])]

    def _block(self, taps: Sequence[Tap], indices: list[int]) -> list[list[int]]:
        """The taps of one signal, those of a lag together."""
        if self.by_component:
            sign = -1 if self.oldest_first else 1
            return [
                [index]
                for index in sorted(
                    indices, key=lambda i: (taps[i].component, sign * taps[i].delay)
                )
            ]
        lags: dict[int, list[int]] = {}
        for index in indices:
            lags.setdefault(taps[index].delay, []).append(index)
        block = list(lags.values())
        return block[::-1] if self.oldest_first else block


NO_DIFFERENCE = "ours"
OURS, OWN_U = Convention(), Convention(own_u=True)

# The words of a text, in the order in which they are written, each with its field and value.
WORDS: dict[str, tuple[str, object]] = {
    "-u": ("negative_u", True),
    "-y": ("negative_y", True),
    "z for y": ("signal", "z"),
    "r - y for y": ("signal", "r - y"),
    "r + y for y": ("signal", "r + y"),
    "y first": ("y_first", True),
    "interleaved": ("is_interleaved", True),
    "oldest first": ("oldest_first", True),
    "by component": ("by_component", True),
    "by rows": ("stacking", "rows"),
    "lags by rows": ("stacking", "rows of each lag"),
    "own u": ("own_u", True),
}
PHRASES = {
    "-u": "theta acts on -u(k-i)",
    "-y": "theta acts on -y (negative feedback)",
    "z for y": "the controller reads z in place of y",
    "r - y for y": "the controller reads r - y in place of y",
    "r + y for y": "the controller reads r + y in place of y",
    "y first": "the y part of theta is first",
    "interleaved": "theta is interleaved, lag by lag",
    "oldest first": "the oldest lag is first",
    "by component": "theta is sorted by component, then by lag",
    "by rows": "theta is stacked by rows",
    "lags by rows": "the matrix of each lag is stacked by rows",
    "own u": "Phi holds u before its limits",
}


def _has(convention: Convention, word: str) -> bool:
    name, value = WORDS[word]
    return bool(getattr(convention, name) == value)


def convention_of(text: str | Convention | None) -> Convention:
    """Read a convention from its words, in any order.

    Raises
    ------
    InputError
        Where a word is not known, or two contradict each other.
    """
    if isinstance(text, Convention):
        return text
    if text is None:
        return OURS
    if not isinstance(text, str):
        raise InputError(f"convention = {text!r} must be a text such as '-y, y first'.")
    convention = OURS
    for word in filter(None, (" ".join(part.split()) for part in text.lower().split(","))):
        if word == NO_DIFFERENCE:
            continue
        if word not in WORDS:
            raise InputError(
                f"convention = {shortened(text)!r}: {shortened(word, 40)!r} is not known; "
                f"join any of {', '.join(map(repr, WORDS))} by commas."
            )
        name, value = WORDS[word]
        known = getattr(convention, name)
        if known not in (getattr(OURS, name), value):
            raise InputError(f"convention = {text!r} has two words for one setting; remove one.")
        convention = replace(convention, **{name: value})  # type: ignore[arg-type]
    return convention


def orders(structure: Structure) -> Iterator[Convention]:
    """Every order of theta that differs from the ones before, ours first."""
    is_several = max(structure.l_u, structure.l_y, structure.l_r) > 1
    positions = set()
    for stacking, by_component in itertools.product(STACKINGS, NO_YES):
        if (stacking != "columns" and structure.l_u == 1) or (by_component and not is_several):
            continue
        for oldest, interleaved, y_first in itertools.product(NO_YES, NO_YES, NO_YES):
            order = Convention(
                y_first=y_first, is_interleaved=interleaved, oldest_first=oldest,
                by_component=by_component, stacking=stacking,
            )  # fmt: skip
            key = order.positions(structure).tobytes()
            if key not in positions:
                positions.add(key)
                yield order


def differences(convention: Convention) -> int:
    """The number of settings that differ from ours."""
    return sum(getattr(convention, f.name) != f.default for f in fields(Convention))
