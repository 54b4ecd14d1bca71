"""The report of the contents of a log."""

from __future__ import annotations

from typing import Any

import numpy as np

from rcac_numeric.reports._sheet import Block, Fact, Section, Sheet, SheetTable, Text, cells
from rcac_numeric.signals._clock import Clock
from rcac_numeric.signals._log_contents import LogColumn, LogContents

MOST_LISTED = 40  # columns in a table; the record has all


def log_sheet(log: LogContents) -> Sheet:
    """The report of the contents of a log: columns, clocks, and the signals in use."""
    used = {clock.column: "time" for clock in log.clocks.values() if clock is not None}
    used |= {name: role for role, names in log.roles.items() for name in names}
    health = [Text(log.unread, "bad")] if log.unread else []
    return Sheet(
        title=log.source, remark=f": {log.format}", health=tuple(health),
        sections=(_columns(log, used), _clocks(log), _roles(log)),
    )  # fmt: skip


def _columns(log: LogContents, used: dict[str, str]) -> Section:
    listed = sorted(log.columns, key=lambda c: c.full_name not in used)[:MOST_LISTED]
    rows = tuple(_row(c, used.get(c.full_name, "")) for c in log.columns if c in listed)
    heads = ("column", "unit", "type", "rows", "missing", "range", "rounding", "used as")
    blocks: list[Block] = [SheetTable(heads, rows, has_names=True)]
    if len(log.columns) > len(listed):
        words = f"{len(log.columns) - len(listed)} columns more; --json lists them"
        blocks.append(Text(words, "quiet"))
    record = {"columns": [_record(c, used.get(c.full_name)) for c in log.columns]}
    return Section("Columns", tuple(blocks), {"log": {"format": log.format, **record}})


def _row(column: LogColumn, role: str) -> tuple[Any, ...]:
    low, high = _range(column)
    return cells(
        column.full_name, column.unit, column.stored, _shape(column),
        str(column.missing) if column.missing else "",
        "" if low is None else f"{low:.4g} to {high:.4g}", _rounding(column, role), role,
    )  # fmt: skip


def _rounding(column: LogColumn, role: str) -> str:
    """The rounding in a few characters, where the type does not say it."""
    if column.values is None or column.values.dtype.kind == "c" or role == "time":
        return ""
    rounding = column.rounding
    words = []
    if rounding.step and rounding.number_format != "integer":
        words.append(f"step {rounding.step:.4g}")
    elif rounding.number_format not in ("float64", column.stored):
        words.append(rounding.number_format)
    if rounding.printing != "exact":
        words.append(f"{rounding.places} {rounding.printing}")
    return ", ".join(words)


def _shape(column: LogColumn) -> str:
    shape = () if column.values is None else np.shape(column.values)
    return " x ".join(map(str, shape)) if len(shape) > 1 else str(column.rows)


def _range(column: LogColumn) -> tuple[float | None, float | None]:
    """The least and the largest finite number."""
    values = column.values
    if values is None or values.dtype.kind == "c":
        return None, None
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (None, None)


def _record(column: LogColumn, role: str | None) -> dict[str, Any]:
    low, high = _range(column)
    rounding = column.rounding
    return {
        "name": column.full_name, "unit": column.unit, "type": column.stored,
        "rows": column.rows, "width": _width(column), "missing": column.missing,
        "least": low, "largest": high, "problem": column.problem, "used_as": role,
        "rounding": {
            "format": rounding.number_format, "printing": rounding.printing,
            "places": rounding.places, "quantum": rounding.quantum, "relative": rounding.relative,
        },
    }  # fmt: skip


def _width(column: LogColumn) -> int:
    values = column.values
    return 0 if values is None else int(values.size // max(column.rows, 1))


def _clocks(log: LogContents) -> Section:
    blocks: list[Block] = []
    records = {}
    for topic, clock in log.clocks.items():
        name = topic or "Clock"
        if clock is None:
            blocks.append(Fact(name, "no column of times: the rows are steps of equal distance"))
        else:
            is_good = clock.is_regular and not clock.missing
            blocks.append(Fact(name, str(clock), "plain" if is_good else "warning"))
        records[topic] = None if clock is None else _clock_record(clock)
    return Section("Clock", tuple(blocks), {"log": {"clocks": records}})


def _clock_record(clock: Clock) -> dict[str, Any]:
    return {
        "column": clock.column, "unit": clock.unit, "sample_time": clock.sample_time,
        "rows": clock.rows, "steps": clock.steps, "missing": clock.missing, "gaps": clock.gaps,
        "longest_gap": clock.longest_gap, "jitter": clock.jitter, "repeated": clock.repeated,
        "turning": clock.turning, "problem": clock.problem,
    }  # fmt: skip


def _roles(log: LogContents) -> Section:
    blocks: list[Block] = [Fact(role, ", ".join(names)) for role, names in log.roles.items()]
    blocks += [Text(note, "warning") for note in log.notes]
    record = {"roles": log.roles, "notes": log.notes, "refused": log.unread or None}
    return Section("Used by rcac check and rcac design", tuple(blocks), {"log": record})
