"""Controllers that read a newer or an older sample than their structure says."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Result
from rcac_numeric.checks._convention_search import ConventionMatch, search_conventions
from rcac_numeric.checks._replays import ControlReplay, Replayer
from rcac_numeric.controllers._structure import Structure, Tap

PADDED = ("IIR", "FIR", "quasi-FIR")  # which have one lag of y more with k_c = 0
MOST_PAIRS = 4  # coefficients whose sums are written out


@dataclass(frozen=True, eq=False)
class SampleShift(Result):
    """The samples by which the logged u is the output of the logged theta.

    Attributes
    ----------
    structure : Structure
        That of the logged theta.
    read : int
        Lags of the measurements beyond those of the structure: -1 for y(k) in place of y(k-1).
    summed : bool
        Whether the sum of an integrator holds one newer sample.
    match : ConventionMatch
    """

    structure: Structure
    read: int
    summed: bool
    match: ConventionMatch

    @property
    def conversion(self) -> str:
        """A line of Octave that makes theta of the structure that is read; empty if none does."""
        if not self.summed:
            return ""
        positions = self.match.convention.positions(self.structure).reshape(-1, self.structure.l_u)
        pairs = [
            (int(positions[p, i]) + 1, int(positions[s, i]) + 1)
            for p, s in _newest_of_sums(self.structure).items()
            for i in range(self.structure.l_u)
        ]
        if len(pairs) > MOST_PAIRS:
            return ""
        return " ".join(f"theta(:, {p}) = theta(:, {p}) + theta(:, {s});" for p, s in pairs)

    @property
    def next_step(self) -> str:
        """The options of the check, and the change of theta before it."""
        options = [self.match.options] if self.match.options else []
        before = []
        if self.read and (self.structure.name in PADDED or _is_pid(self.structure)):
            options.append(f"--k-c {self._newest}")
            if not _is_pid(self.structure):
                before.append(f"theta has coefficients 0 of y({_ago(self.structure.n_c)})")
        elif self.read:
            options.append("a structure whose taps of y have these lags")
        if self.summed:
            line = self.conversion
            before.append(f"{line} in Octave" if line else "each coefficient of I is added to P")
        words = "the check" + (f" with {' and '.join(options)}" if options else "")
        return words + (f", after {' and '.join(before)}" if before else "")

    @property
    def _newest(self) -> int:
        """The least lag of the measurements that are read."""
        return min(t.delay for t in self.structure.taps if t.signal != "u") + self.read

    def __str__(self) -> str:
        signal: str = self.match.convention.signal
        signal = f"({signal})" if " " in signal else signal
        words = []
        if self.read:
            words.append(f"the newest sample that the controller reads is {signal}"
                         f"({_ago(self._newest)})")  # fmt: skip
        if self.summed:
            last = _last_of_sum(self.structure) + self.read - 1
            words.append(f"its sum runs up to {signal}({_ago(last)})")
        return (
            f"The log contains u = Phi theta, if {' and '.join(words)} (worst relative difference "
            f"{self.match.replay.worst:.2g}). Repeat {self.next_step}."
        )


def _ago(lag: int) -> str:
    return "k" if lag == 0 else f"k - {lag}" if lag > 0 else f"k + {-lag}"


def _is_pid(structure: Structure) -> bool:
    return set(structure.name) <= set("PID")


def _is_sum(structure: Structure, tap: Tap) -> bool:
    return tap.signal == "derived" and structure.derived[tap.component].pole == 1.0


def _last_of_sum(structure: Structure) -> int:
    """The lag of the newest sample in the sums of a structure."""
    return min(tap.delay for tap in structure.taps if _is_sum(structure, tap))


def _newest_of_sums(structure: Structure) -> dict[int, int]:
    """The taps of y one step newer than each sum, by which the sum grows: their coefficients add.

    Empty where the structure has none, or a sum has a limit.
    """
    taps = list(structure.taps)
    pairs = {}
    for index, tap in enumerate(taps):
        if not _is_sum(structure, tap):
            continue
        signal = structure.derived[tap.component]
        inputs = [i for i, weight in enumerate(signal.now) if weight]
        newest = Tap("y", inputs[0], tap.delay - 1) if len(inputs) == 1 else None
        is_plain = newest in taps and signal.now[inputs[0]] == 1 and not any(signal.before)
        if newest is None or not is_plain or signal.limit < float("inf"):
            return {}
        pairs[taps.index(newest)] = index
    return pairs


def _moved(structure: Structure, read: int, summed: bool) -> Structure:
    taps = [
        tap if tap.signal == "u" else
        replace(tap, delay=tap.delay + read - (summed and _is_sum(structure, tap)))
        for tap in structure.taps
    ]  # fmt: skip
    longest = max(tap.delay for tap in taps)
    return replace(structure, taps=tuple(taps), n_c=max(structure.n_c, longest))


def _shifts(structure: Structure) -> Iterator[tuple[int, bool]]:
    """The shifts (read, summed) that a structure has, without that of the structure itself."""
    lags = [tap.delay for tap in structure.taps if tap.signal != "u"]
    reads = [0]
    if lags and min(lags) > 0:
        reads.append(-1)
    elif _is_pid(structure):
        reads.append(1)
    for summed in (False, True)[: 1 + bool(_newest_of_sums(structure))]:
        yield from ((read, summed) for read in reads if read or summed)


def search_sample_shifts(
    replayer: Replayer, ours: ControlReplay, limits: tuple[Array, Array] | None = None
) -> SampleShift | None:
    """Try newer and older samples of y, and sums that hold a newer one, with every convention."""
    for read, summed in _shifts(replayer.structure):
        moved = replayer.with_structure(_moved(replayer.structure, read, summed))
        search = search_conventions(moved, ours, limits)
        if search.matches:
            return SampleShift(replayer.structure, read, summed, search.matches[0])
    return None
