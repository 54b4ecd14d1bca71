"""The command `rcac export`: write a controller as C or as an FMU."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from compensator_theory.errors import InputError
from rcac_experiments.cli._cases import case_experiment, complete_case, values_option
from rcac_experiments.cli._output import as_json_option, budget_option, show
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_numeric.arrays._values import replaced
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._supervision import Supervision
from rcac_numeric.engine._runs import Run, load_run
from rcac_numeric.export._fmu import VERSIONS, export_fmu
from rcac_numeric.export._folder import LAYOUTS, Export, export_controller
from rcac_numeric.export._header import REALS
from rcac_numeric.export._recording import STEPS
from rcac_numeric.reports._sheet import Fact, Section, Sheet, Text

WRITTEN = "Written by `rcac export`"  # in the README of each export


@click.command("export")
@click.argument("case", shell_complete=complete_case)
@click.option("-o", "--output", "folder", required=True, type=click.Path(path_type=Path),
              help="The folder to write, or a file that ends in .fmu.")  # fmt: skip
@click.option("--sample-time", type=click.FloatRange(min=0, min_open=True), metavar="SECONDS",
              help="Sample time of an FMU; default: that of the plant in CASE.")  # fmt: skip
@click.option("--fmi", type=click.Choice(VERSIONS), default="2.0", show_default=True,
              help="Version of the FMI standard of an FMU.")  # fmt: skip
@click.option("--real", type=click.Choice(REALS), default="float64", show_default=True,
              help="Floating-point type of all numbers.")  # fmt: skip
@click.option("--layout", "layouts", type=click.Choice(LAYOUTS), multiple=True, default=("c",),
              show_default=True, help="Project files beside the core. Repeatable.")  # fmt: skip
@click.option("--prefix", default="rcac", show_default=True, help="Prefix of all C names.")
@click.option("--fixed", is_flag=True,
              help="Export the final controller of the run, without adaptation.")  # fmt: skip
@click.option("--run", "name", help="Run of CASE; default: the first.")
@click.option("--live-order", type=click.IntRange(min=0),
              help="Allow a new target model, up to this order, at run time.")  # fmt: skip
@click.option("--supervised", is_flag=True,
              help="Continue after missed samples and overflows, and record them.")  # fmt: skip
@values_option
@budget_option(of_runs=True)
@as_json_option
def export(
    *,
    case: str,
    folder: Path,
    sample_time: float | None,
    fmi: str,
    real: str,
    layouts: tuple[str, ...],
    prefix: str,
    fixed: bool,
    name: str | None,
    live_order: int | None,
    supervised: bool,
    values: tuple[str, ...],
    as_json: bool,
    budget: ExperimentBudget,
) -> None:
    """Write the controller of CASE as C or as an FMU, and replay it if a C compiler is installed.

    CASE is the number of an example (see `rcac list`), the path of a TOML file, or a run saved by
    `rcac verify CASE --save RUN.npz`.
    """
    supervision = Supervision() if supervised else None
    with np.errstate(all="ignore"):
        run, words = _run(case, values, budget, name, fixed)
        controller = FixedController(run.compensator, run.settings.l_r) if fixed else run
        if folder.suffix == ".fmu":
            _require_defaults(real, layouts, prefix, live_order)
            period = run.sample_time if sample_time is None else sample_time
            if period is None:
                raise InputError(f"an FMU needs a sample time: --sample-time 0.01 for {folder}.")
            file = export_fmu(
                controller, folder, sample_time=period, version=fmi,
                saturation=run.saturation, supervision=supervision,
            )  # fmt: skip
            show(_fmu_sheet(file, fmi, period, words), as_json)
            return
        if folder.is_file():
            raise InputError(f"{folder} is a file; -o needs a folder, or an FMU that ends in .fmu.")
        _require_export(folder)
        exported = export_controller(
            controller,
            folder,
            real=real,
            layout=layouts,
            prefix=prefix,
            live_order=live_order,
            saturation=run.saturation,
            supervision=supervision,
            run=run,
        )
    show(_sheet(exported, words), as_json)


def _require_defaults(
    real: str, layouts: tuple[str, ...], prefix: str, live_order: int | None
) -> None:
    options = {
        "--real": real != "float64",
        "--layout": layouts != ("c",),
        "--prefix": prefix != "rcac",
        "--live-order": live_order is not None,
    }
    if wrong := [option for option, is_set in options.items() if is_set]:
        raise InputError(f"{' and '.join(wrong)} apply to C, not to an FMU.")


def _require_export(folder: Path) -> None:
    """Refuse a folder with files, unless its README says that an export wrote it."""
    if not folder.is_dir() or not any(folder.iterdir()):
        return
    text = folder / "README.md"
    if not text.is_file() or WRITTEN not in text.read_text(encoding="utf-8", errors="replace"):
        raise InputError(f"{folder} has files that rcac export did not write; name a new folder.")


def _fmu_sheet(file: Path, version: str, sample_time: float, words: str) -> Sheet:
    facts = (
        Fact("file", str(file)),
        Fact("interface", f"FMI {version}, co-simulation"),
        Fact("sample time", f"{sample_time:g} s"),
        Fact("numbers", "float64"),
    )
    record = {"file": str(file), "fmi": version, "sample_time": sample_time}
    return Sheet(
        "A controller as an FMU",
        health=(Text(words),),
        sections=(Section(blocks=facts, record={"export": record}),),
    )


def _run(
    case: str, values: tuple[str, ...], budget: ExperimentBudget, name: str | None, fixed: bool
) -> tuple[Run, str]:
    """Return the run to export, or its first steps if they suffice, and words on its controller."""
    if case.endswith(".npz"):
        if values or name:
            raise InputError(f"{case} is a saved run; --set and --run need a TOML file.")
        run = load_run(case)
        return run, f"Exported: {_controller(run, fixed)}."
    experiment = case_experiment(case, values, budget)
    if name is not None and name not in experiment.runs:
        raise InputError(f"--run {name}: the runs are {', '.join(map(repr, experiment.runs))}.")
    chosen = experiment.main_run if name is None else experiment.runs[name]
    if chosen.reference:
        raise InputError("this run uses ball arithmetic; choose another one with --run.")
    steps = chosen.steps if fixed else min(chosen.steps, STEPS)
    run = replaced(chosen, steps=steps, seeds=1, repetitions=1).execute().first.run
    words = f"Exported: run {chosen.name!r}, {_controller(run, fixed)}."
    if (first := experiment.main_run.name) != chosen.name:
        words += f" The first run of {case}, the verdict in the file of a design, is {first!r}."
    return run, words


def _controller(run: Run, fixed: bool) -> str:
    """Whether the exported controller adapts."""
    if fixed:
        return "its final controller, fixed"
    settings = run.settings
    if not isinstance(settings, ControllerSettings):
        return "a fixed controller"
    if (0, None) in settings.freeze:
        return (
            "the fixed controller theta(0): adaptation is frozen from step 0; --fixed leaves its "
            "code out"
        )
    return "adaptive"


def _sheet(exported: Export, words: str) -> Sheet:
    health = [Text(words), *(Text(warning, "warning") for warning in exported.warnings)]
    if not exported.is_verified:
        health.append(Text("Not compiled: this machine has no C compiler.", "warning"))
    facts = [
        Fact("folder", str(exported.folder)),
        Fact("files", ", ".join(exported.files)),
        Fact("numbers", exported.real),
        Fact("RAM", f"{exported.state_bytes} bytes"),
        Fact("constants", f"{exported.constant_bytes} bytes"),
    ]
    if exported.is_verified:
        facts.append(Fact("replay", exported.replay, "good"))
    if exported.agreement:
        facts.append(Fact("float32", exported.agreement))
    record = {
        "folder": str(exported.folder),
        "files": list(exported.files),
        "real": exported.real,
        "state_bytes": exported.state_bytes,
        "constant_bytes": exported.constant_bytes,
        "replay": exported.replay,
        "agreement": exported.agreement,
        "warnings": list(exported.warnings),
    }
    return Sheet(
        "A controller in C",
        health=tuple(health),
        sections=(Section(blocks=tuple(facts), record={"export": record}),),
    )
