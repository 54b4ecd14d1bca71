"""What is said of a run."""

from __future__ import annotations

from rcac_numeric.engine.runs import Run
from rcac_numeric.health.diagnosis import loop_health
from rcac_numeric.reports.health import health_lines
from rcac_numeric.reports.sheets.sheet import Sheet


def run_sheet(run: Run) -> Sheet:
    """How it ended, and the health of its loop."""
    remark = f": {run.outcome} after {run.steps} steps"
    return Sheet("Run", remark, health_lines(loop_health(run)))
