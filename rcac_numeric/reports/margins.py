"""The margins of a loop as a section of a report."""

from __future__ import annotations

from dataclasses import fields
from math import isnan
from typing import Any

from rcac_numeric.margins.boundaries import StabilityBoundary
from rcac_numeric.margins.classical import Margins
from rcac_numeric.margins.disk import DiskMargin
from rcac_numeric.reports.sheets.sheet import Section, Sheet, Table, Text, cells

HEADS = ("", "margin", "at rad/sample", "pole radius there")


def margins_section(name: str, margins: Margins) -> Section:
    """The margins of the loop opened at the signal `name`, each with the poles that show it."""
    record: dict[str, Any] = {
        "is_stable": margins.is_stable,
        "gain_crossovers": margins.gain_crossovers,
        "phase_crossovers": margins.phase_crossovers,
    }
    whole = {"margins": {name: record}}
    remark = f", the loop opened at {name}"
    if not margins.is_stable:
        return Section("Margins", (Text(str(margins), "bad"),), whole, remark)
    rows = []
    for label, found, unit in _boundaries(margins):
        omega = f"{found.omega:.6g}" if found.is_reached else ""
        there = f"{found.radius_at:.12f}" if found.is_reached else ""
        rows.append(cells(label, f"{found.value:.6g}{unit}", omega, there))
        record[label.replace(" ", "_")] = {
            part: getattr(found, part)
            for part in ("value", "omega", "is_reached", "radius_before", "radius_at",
                         "radius_after")
        }  # fmt: skip
    record["delay_time"] = margins.delay_time
    disk = margins.disk
    record["disk"] = disk_record(disk)
    if disk is None:
        return Section("Margins", (Table(HEADS, tuple(rows)),), whole, remark)
    low, high = disk.gain
    rows.append(
        cells(
            "disk, S - T",
            f"{disk.alpha:.6g}: {low:.4g} to {high:.4g}, {disk.phase:.4g} deg",
            f"{disk.omega:.6g}",
            "" if isnan(disk.radius_at) else f"{disk.radius_at:.12f}",
        )
    )
    peaks = (
        f"peaks: |S| {disk.S_peak:.4g} at {disk.S_omega:.4g}, |T| {disk.T_peak:.4g} at "
        f"{disk.T_omega:.4g} rad/sample"
    )
    return Section("Margins", (Table(HEADS, tuple(rows)), Text(peaks)), whole, remark)


def margins_sheet(margins: Margins) -> Sheet:
    """The margins of one loop as a report of their own."""
    return Sheet("", sections=(margins_section("u", margins),))


def disk_record(disk: DiskMargin | None) -> dict[str, Any] | None:
    """A disk margin as a record."""
    if disk is None:
        return None
    return {part.name: getattr(disk, part.name) for part in fields(disk)}


def _boundaries(margins: Margins) -> list[tuple[str, StabilityBoundary, str]]:
    """Name, boundary and unit of each margin of a stable loop."""
    assert margins.gain_up and margins.gain_down and margins.phase_lag and margins.phase_lead
    assert margins.delay
    seconds = "" if margins.delay_time is None else f" = {margins.delay_time:.6g} s"
    return [
        ("gain up", margins.gain_up, ""),
        ("gain down", margins.gain_down, ""),
        ("phase lag", margins.phase_lag, " deg"),
        ("phase lead", margins.phase_lead, " deg"),
        ("delay", margins.delay, f" steps{seconds}"),
    ]
