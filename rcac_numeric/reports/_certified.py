"""The report of a certified set."""

from __future__ import annotations

from typing import Any

from rcac_numeric.analysis._certified_set import CertifiedSet, direction_texts
from rcac_numeric.analysis._certified_tail import CertifiedTail
from rcac_numeric.analysis._peak_bounds import PeakBounds
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.reports._sheet import (
    Block,
    Fact,
    Section,
    Sheet,
    SheetTable,
    Text,
    cells,
    counted,
)

FEW = 24  # coefficients that the table lists
MOST_COEFFICIENTS, MOST_PLANTS = 24, 5  # of a run that other reports prove unasked


def certified_sheet(region: CertifiedSet) -> Sheet:
    """The report: exclusions, the proof, members, coefficients and decay."""
    proved = region.is_verified
    plants = counted(len(region.members), "plant")
    health = (
        *(Text(f"Not covered: {words}.", "warning") for words in region.uncovered),
        Text(
            f"Proved in exact arithmetic for {plants}: no motion of theta within this set "
            "destabilises the loop.",
            "good",
        )
        if proved
        else Text("NOT proved: the certificate of this set does not hold.", "bad"),
    )
    record = {"proved": proved, "uncovered": list(region.uncovered), "rate": region.rate}
    sections = (
        Section(record=record),
        _members(region),
        _coefficients(region),
        _decay(region),
        _dependent(region),
    )
    remark = f" of {region.structure.name}, {counted(len(region.center), 'coefficient')}"
    return Sheet("Certified set", remark, health, sections)


def _members(region: CertifiedSet) -> Section:
    peaks = region.peaks
    rows = tuple(
        cells(member.name, str(len(member.P)), f"{peaks[member.name]:.4g}")
        for member in region.members
    )
    table = SheetTable(("plant", "states of the loop", "norm, at most 1"), rows)
    return Section("Plants", (table,), {"norms": peaks})


def _coefficients(region: CertifiedSet) -> Section:
    intervals = region.intervals()
    rows = tuple(
        cells(name, f"{center:.6g}", f"{low:.6g}", f"{high:.6g}")
        for (name, (low, high)), center in zip(intervals.items(), region.center, strict=True)
    )
    heads = ("coefficient", "theta_0", "least", "largest")
    blocks: list[Block] = [SheetTable(heads, rows[:FEW])]
    if len(rows) > FEW:
        blocks.append(Text(f"and {len(rows) - FEW} more: `intervals()`", "quiet"))
    remark = ": projections of the ellipsoid; not every combination lies inside"
    record = {"intervals": {name: list(ends) for name, ends in intervals.items()}}
    return Section("Coefficients", tuple(blocks), record, remark)


def _decay(region: CertifiedSet) -> Section:
    shares = region.decay()
    rows = tuple(
        cells(f"{rate:g}", f"{share:.3g}" if share else "none: theta_0 decays more slowly")
        for rate, share in shares.items()
    )
    table = SheetTable(("x(k) decays as", "within this share of the radius"), rows)
    record = {"decay": {f"{rate:g}": share for rate, share in shares.items()}}
    return Section("Decay", (table,), record, ", computed in float64")


def _dependent(region: CertifiedSet) -> Section:
    texts = direction_texts(region.dependent, region.structure)
    if not texts:
        return Section(record={"dependent": []})
    lines = tuple(Fact(f"direction {i}", words) for i, words in enumerate(texts[:FEW], start=1))
    note = Text("The set is capped along them; stability needs no bound there.", "quiet")
    remark = ": changes of theta that move no pole of any plant"
    return Section("Dependent directions", (*lines, note), {"dependent": list(texts)}, remark)


def tail_sheet(tail: CertifiedTail) -> Sheet:
    """The report of a run: from which step on the loop is proved stable, plant by plant."""
    uncovered = () if tail.set is None else tail.set.uncovered
    notes = tuple(Text(f"Not covered: {words}.", "warning") for words in uncovered)
    section = Section(record=tail_record(tail))
    health = (*notes, *tail_lines(tail))
    return Sheet("Run as a time-varying loop", health=health, sections=(section,))


def tail_lines(tail: CertifiedTail) -> tuple[Text, ...]:
    """The verdict on each plant of a run."""
    if not tail.earlier:
        return (tail_line(tail),)
    lines = [(one, tail_line(one)) for one in (*tail.earlier, tail)]
    return tuple(
        Text(f"Steps {one.start} to {one.stop - 1}: {line.words}", line.level)
        for one, line in lines
    )


def tail_record(tail: CertifiedTail) -> dict[str, Any]:
    """The first step of the proof and the reasons where there is none."""
    segments = [
        {
            "start": one.start,
            "stop": one.stop,
            "k0": one.k0,
            "earliest": one.earliest,
            "reason": one.reason,
        }
        for one in (*tail.earlier, tail)
    ]
    return {"k0": tail.k0, "segments": segments}


def proof_obstacle(l_theta: int, plants: int = 1) -> str:
    """The reason why a report leaves the proof of a run to `certified_from`; or nothing."""
    if l_theta > MOST_COEFFICIENTS:
        return (
            f"theta has {l_theta} coefficients, and beyond {MOST_COEFFICIENTS} the proof takes "
            "seconds: certified_from(run)"
        )
    if plants > MOST_PLANTS:
        return f"each of the {plants} plants needs a proof of its own: certified_from(run)"
    return ""


def proof_lines(tail: CertifiedTail | str) -> tuple[Text, ...]:
    """The line of a report on the proof of a run, or on why it was not evaluated."""
    if isinstance(tail, str):
        return (Text(f"Proof of stability while theta moves: not evaluated: {tail}."),)
    return tail_lines(tail)


def tail_line(tail: CertifiedTail) -> Text:
    """The verdict on one plant of a run, in a sentence."""
    if tail.k0 is None:
        return Text(f"No step from which on the loop is proved stable: {tail.reason}.", "warning")
    if not tail.is_verified:
        return Text("NOT proved: the certificate does not hold.", "bad")
    motion = ", while theta still moves" if tail.is_moving else ", with a constant theta"
    words = f"Proved in exact arithmetic: the loop is exponentially stable from step {tail.k0} on"
    if tail.earliest is None:
        return Text(f"{words}{motion}.", "good")
    first = (
        "no set begins earlier"
        if tail.k0 == tail.earliest
        else f"no set begins before step {tail.earliest}"
    )
    return Text(f"{words}{motion}; {first}.", "good")


def peak_sheet(bounds: PeakBounds) -> Sheet:
    """The report of bounds of z and u for bounded w: the claim, the bounds, and the channels."""
    region, share = bounds.region, bounds.share
    plants = counted(len(region.members), "plant")
    verdict = (
        Text(
            f"Proved in exact arithmetic for {plants}: from rest, no motion of theta within "
            f"{share:.3g} of the radius takes z or u beyond these bounds.",
            "good",
        )
        if bounds.is_verified
        else Text("NOT proved: the certificate of these bounds does not hold.", "bad"),
        Text(
            f"abs(z) at most {_listed(bounds.z)}, abs(u) at most {_listed(bounds.u)}; with theta = "
            f"theta_0 abs(z) reaches {_listed(bounds.held)}.",
            "quiet",
        ),
    )
    plant = region.members[0].plant
    names = [f"z {i + 1}" for i in range(len(bounds.z))]
    names += [f"u {i + 1}" for i in range(len(bounds.u))]
    held = [f"{value:.4g}" for value in bounds.held] + ["" for _ in bounds.u]
    values = [*bounds.z, *bounds.u]
    rows = tuple(
        cells(name, f"{value:.4g}", at_rest)
        for name, value, at_rest in zip(names, values, held, strict=True)
    )
    table = SheetTable(("signal", "bound of its abs", "with theta = theta_0"), rows)
    gains = [
        cells(names[p.output], plant.channels[p.channel], p.member, f"{p.gain:.4g}")
        for p in sorted(bounds.proofs, key=lambda p: -p.gain * bounds.w_peak[p.channel])[:FEW]
    ]
    of_channels = SheetTable(("signal", "channel of w", "plant", "gain"), tuple(gains))
    record = {
        "proved": bounds.is_verified, "share": share, "w_peak": bounds.w_peak.tolist(),
        "z": bounds.z.tolist(), "u": bounds.u.tolist(), "held": bounds.held.tolist(),
    }  # fmt: skip
    peaks = ", ".join(
        f"{name} {peak:.4g}" for name, peak in zip(plant.channels, bounds.w_peak, strict=True)
    )
    sections = (
        Section(record=record),
        Section("Bounds", (table,), {}, f" for abs(w) at most {peaks}"),
        Section("Gains", (of_channels,), {}, ": largest first; they add up"),
    )
    remark = f", theta within {share:.3g} of the radius"
    return Sheet("Bounds of z and u", remark, verdict, sections)


def _listed(values: Array) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
