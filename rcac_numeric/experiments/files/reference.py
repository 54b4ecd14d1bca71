"""The reference tables of docs/experiment-files.md, from the declarations of the format."""

from __future__ import annotations

from typing import Any

from rcac_numeric.experiments.figure_requests import FIGURE
from rcac_numeric.experiments.files.builder import FILE
from rcac_numeric.experiments.files.claims import CHECK, CLAIM
from rcac_numeric.experiments.files.controllers import CONTROLLER
from rcac_numeric.experiments.files.estimation import CHECK as ESTIMATION_CHECK
from rcac_numeric.experiments.files.estimation import ESTIMATOR, RUN, TRIAL
from rcac_numeric.experiments.files.plants import CHANGE, PLANT, PROBLEMS
from rcac_numeric.experiments.files.runs import COURSE, OPEN_VALUE, OVERRIDE, SATURATION
from rcac_numeric.experiments.files.signals import SIGNAL, SIGNALS
from rcac_numeric.experiments.files.structures import Derived
from rcac_numeric.experiments.files.targets import TARGETS
from rcac_numeric.experiments.files.updates import UPDATES
from rcac_numeric.experiments.format.markdown import (
    by_key_table,
    keys_table,
    kind_keys_table,
    kinds_table,
    with_tables,
)
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.judging.reading import open_table


def reference_tables() -> dict[str, str]:
    """Every generated table by its name in the page."""
    structures = CONTROLLER.table.kinds["structure"]
    measures = CHECK.kinds["measure"]
    tables = {
        "file": keys_table(FILE),
        "plant": keys_table(PLANT.table),
        "plant.changes": keys_table(CHANGE),
        "signals": keys_table(SIGNALS),
        "a signal": by_key_table(SIGNAL),
        "controller": keys_table(CONTROLLER.table),
        "controller.derived": keys_table(Table(Derived)),
        "saturation": keys_table(SATURATION.table),
        "run": keys_table(COURSE.table),
        "runs": keys_table(OVERRIDE),
        "claims": keys_table(CLAIM),
        "claims.checks": keys_table(CHECK),
        "open": keys_table(open_table(OPEN_VALUE)),
        "figures": keys_table(FIGURE),
    }
    spread: dict[str, tuple[str, Kinds[Any]]] = {
        "problems": ("problem", PROBLEMS),
        "models": ("model", TARGETS),
        "structures": ("structure", structures),
        "updates": ("update", UPDATES),
        "measures": ("measure", measures),
    }
    for name, (selector, kinds) in spread.items():
        tables[name] = kinds_table(selector, kinds)
        tables[f"keys of {name}"] = kind_keys_table(kinds)
    tables["estimation"] = keys_table(TRIAL.table)
    tables["estimation runs"] = keys_table(RUN)
    tables["estimation measures"] = kinds_table("measure", ESTIMATION_CHECK.kinds["measure"])
    for name, kind in ESTIMATOR.table.kinds["kind"].kinds.items():
        if name != "ukf":
            tables[f"estimator {name}"] = keys_table(kind.variants[0].table)
    for key in UPDATES.kinds["ud"].variants[0].table.keys:
        if isinstance(key.form, Table):
            tables[f"controller.{key.name}"] = keys_table(key.form)
    return tables


def page_with_tables(page: str) -> str:
    """The page docs/experiment-files.md with its tables brought up to date."""
    return with_tables(page, reference_tables())
