"""The check of a controller as one dictionary, ready for JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rcac_numeric.reports.tables import finite_or_none

if TYPE_CHECKING:
    import numpy as np

    from rcac_numeric.checks.check import ControllerCheck
    from rcac_numeric.margins.boundaries import StabilityBoundary
    from rcac_numeric.margins.classical import Margins
    from rcac_numeric.margins.disk import DiskMargin


def as_dict(check: ControllerCheck) -> dict[str, Any]:
    """The check as one dictionary for strict JSON: null stands for infinite and for unknown."""
    replay, drift, costs = check.replay, check.drift, check.costs
    result: dict[str, Any] = {
        "source": check.log.source,
        "steps": check.log.steps,
        "replay": replay and {
            "of": replay.of,
            "agrees": replay.agrees,
            "worst": finite_or_none(replay.worst),
            "worst_step": replay.worst_step,
            "start": replay.start,
            "shift": replay.shift,
        },
        "drift": drift and {
            "is_converged": drift.is_converged,
            "relative": finite_or_none(drift.relative),
            "start": drift.start,
        },
        "controller": {
            "P": check.compensator.past_u.tolist(),
            "Q": check.compensator.past_y.tolist(),
            "poles": _pairs(check.compensator.poles()),
            "internal_models": [
                {
                    "pole": [m.pole.real, m.pole.imag],
                    "omega": m.omega,
                    "rejects": m.rejects,
                    "gains": {name: finite_or_none(g) for name, g in m.gains.items()},
                }
                for m in check.internal_models
            ],
        },
        "unsaid": check.unsaid,
    }  # fmt: skip
    if check.loop is None:
        return result
    result["loop"] = {
        "is_stable": check.loop.is_stable,
        "spectral_radius": check.loop.spectral_radius,
        "poles": _pairs(check.poles),
        "zeros": {name: _pairs(zeros) for name, zeros in check.zeros.items()},
    }
    result["margins"] = {name: _margins(margins) for name, margins in check.margins.items()}
    result["disk_margin"] = _disk(check.disk)
    assert costs is not None
    result["h2"] = {
        "cost": finite_or_none(costs.reached.value),
        "by_noise": {name: finite_or_none(v) for name, v in costs.reached.shares.items()},
        "lqg": None if costs.least is None else costs.least.value,
        "obstacle": costs.obstacle or None,
    }
    if (comparison := check.comparison) is not None:
        result["target"] = {
            "poles": _pairs(comparison.target_poles),
            "worst_pole_distance": comparison.worst_distance,
            "spectrum_distance": finite_or_none(comparison.spectrum_distance),
            "obstacle": comparison.obstacle or None,
        }
    if check.match is not None:
        worst, median = finite_or_none(check.match.worst), finite_or_none(check.match.median)
        result["match"] = {"worst": worst, "median": median}
    if check.split is not None:
        result["residual"] = {k: finite_or_none(v) for k, v in check.split.power().items()}
        if check.loop.is_stable:
            result["residual"]["identity_error"] = finite_or_none(check.split.identity_error)
    return result


def _margins(margins: Margins) -> dict[str, Any]:
    result: dict[str, Any] = {
        "is_stable": margins.is_stable,
        "gain_crossovers": margins.gain_crossovers.tolist(),
        "phase_crossovers": margins.phase_crossovers.tolist(),
    }
    if margins.is_stable:
        for label, found, _ in margin_rows(margins):
            result[label.replace(" ", "_")] = {
                "value": finite_or_none(found.value),
                "omega": finite_or_none(found.omega),
                "is_reached": found.is_reached,
                "radius_before": finite_or_none(found.radius_before),
                "radius_at": finite_or_none(found.radius_at),
                "radius_after": finite_or_none(found.radius_after),
            }
        result["delay_time"] = (
            None if margins.delay_time is None else finite_or_none(margins.delay_time)
        )
        result["disk"] = _disk(margins.disk)
    return result


def _disk(disk: DiskMargin | None) -> dict[str, Any] | None:
    if disk is None:
        return None
    return {name: finite_or_none(value) for name, value in vars(disk).items()}


def _pairs(values: np.ndarray | None) -> list[list[float | None]]:
    return [
        [finite_or_none(float(v.real)), finite_or_none(float(v.imag))]
        for v in ([] if values is None else values)
    ]


def margin_rows(margins: Margins) -> list[tuple[str, StabilityBoundary, str]]:
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
