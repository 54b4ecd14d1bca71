"""One sample of each public data class of rcac_experiments for every seed; as of rcac_numeric."""

from pathlib import Path

import numpy as np

from rcac_experiments import (
    Experiment,
    ExperimentBudget,
    FigureRequest,
    dissertation,
    results,
    sweeps,
    tune,
    verify,
)
from rcac_experiments.files._builder import build
from rcac_numeric import LoopAnalysis
from rcac_numeric.arrays._values import replaced as replace
from tests.rcac_numeric.samples import design, fraction, random, run
from tests.support.equality import SEEDS


def experiment(seed):
    table = {
        "title": f"case {seed}",
        "plant": {"problem": "standard", "G": f"1/(q - {fraction(seed)})"},
        "target": {"model": "fir"},
        "controller": {"n_c": 1, "R_theta": 1.0 + seed, "R_u": {"z_squared": 0.5}},
        "run": {"steps": 10},
    }
    return build(table, "case")


def sweep_table(seed):
    outcomes = np.array(["completed", "diverged"] * 2, dtype=object)
    columns = {"run": np.arange(4), "gain": np.array([1, 1, 2, 2]), "outcome": outcomes,
               "rms": np.abs(random(seed, 4))}  # fmt: skip
    return sweeps.SweepTable(columns, ("gain",), ("rms",))


def erratum(seed):
    return replace(dissertation.find_errata()[0], name=f"entry-{seed}")


SAMPLES = {
    results.Tuned: lambda seed: tune(design(seed), 2, held_out=1, seeds=1, seed=seed),
    results.ExplorerPage: lambda seed: results.ExplorerPage("own", f"page {seed}"),
    results.Erratum: erratum,
    results.ErratumEvidence: lambda seed: results.ErratumEvidence(check=f"chapter_{seed}.step"),
    results.Checked: lambda seed: results.Checked(erratum(seed), ()),
    results.Reproduction: lambda seed: results.Reproduction((), Path(f"gallery-{seed}/index.html")),
    sweeps.Axis: lambda seed: sweeps.Axis("gain", random(seed, 3), sets="plant.gain"),
    sweeps.RandomAxis: lambda seed: sweeps.RandomAxis("gain", "normal", [seed, 1], draws=2),
    sweeps.Metric: lambda seed: sweeps.Metric("peak", "late", {"start": seed}),
    sweeps.Study: lambda seed: sweeps.Study(
        {"run": {"steps": 9}},
        [sweeps.Axis("R_theta", [seed, -1], sets="run.R_theta")],
        [],
        seed=seed,
    ),
    sweeps.Progress: lambda seed: sweeps.Progress(seed, SEEDS, 2.5, diverged=1),
    sweeps.SweepTable: sweep_table,
    results.SweepOverview: lambda seed: results.SweepOverview(
        "store",
        "",
        "",
        "plain",
        "",
        {},
        (),
        seed,
        2,
        {"gain": ("plant.gain", 2)},
        4,
        4,
        sweep_table(seed),
        sweeps.summarise(sweep_table(seed), "rms"),
    ),
    results.ReplayedRun: lambda seed: results.ReplayedRun(
        seed, 1, {"gain": 1}, LoopAnalysis(run(seed)), {"rms": 1.0}, {"rms": np.nan}, "", "", {}
    ),
    sweeps.StoreCheck: lambda seed: sweeps.StoreCheck(
        "store", seed, SEEDS, 1, ((8, 15),), ("why",)
    ),
    results.SweepSummary: lambda seed: sweeps.summarise(sweep_table(seed), "rms"),
    FigureRequest: lambda seed: FigureRequest("responses", "", first=seed),
    ExperimentBudget: lambda seed: ExperimentBudget(memory=1e8 + seed),
    Experiment: experiment,
    results.Verification: lambda seed: verify(experiment(seed)),
}
