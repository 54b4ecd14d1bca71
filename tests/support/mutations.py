"""Mutations of an example's file, generated: what a check must notice."""

import copy
import re
from collections.abc import Iterator
from typing import Any

from rcac_experiments.experiments._experiment import Experiment, verify
from rcac_experiments.files._builder import build
from rcac_experiments.judging._claim import OURS
from rcac_numeric.arrays._values import replaced as replace

Table = dict[str, Any]
OTHER_SOURCE = {"corrected": "printed", "printed": "corrected"}
NUMBER = re.compile(r"(?<![\w.*])\d+\.\d+")


def mutations(table: Table) -> Iterator[tuple[str, Table]]:
    """The tables of an example's file, each changed in one way, with the name of the change."""
    for name, change in (
        ("a coefficient", _coefficient),
        ("the sign of the plant", _sign),
        ("the other source of a plant of the library", _source),
        ("a transition 20 s later", _transition),
        ("no adaptation", _no_adaptation),
        ("no input", _no_input),
        ("another truth", _truth),
        ("a truth that does not change", _constant_truth),
        ("another target", _target),
    ):
        changed = copy.deepcopy(table)
        hits = sum(change(part) for part in _parts(changed))
        if hits:
            yield name, changed


def outcomes(table: Table, number: str) -> list[str]:
    """What comes of each claim that quotes on its own run, with few repetitions."""
    experiment: Experiment = build(table, number)
    claims = [replace(c, over={}, control="") for c in experiment.claims if c.owner != OURS]
    return [verdict.outcome for verdict in verify(experiment.only(claims).reduced(2)).verdicts]


def _parts(table: Table) -> Iterator[Table]:
    """The file, and what each of its runs overrides."""
    yield table
    for run in table.get("runs", []):
        for key in [key for key in run if "." in key]:
            raise AssertionError(f"a dotted key of TOML is a table: {key}")
        yield run


def _scaled(text: str, factor: float) -> str:
    return NUMBER.sub(lambda match: repr(float(match.group(0)) * factor), text, count=1)


def _coefficient(part: Table) -> bool:
    """A coefficient of the plant, 5 % larger; of an exact system, one more or twice as large.

    A plant of the library is sampled half as often again.
    """
    plant = part.get("plant") or part.get("exact") or part.get("estimation") or {}
    if "exact" in part and "G" in plant:
        plant["G"] = f"2*({plant['G']})"
    elif "G" in plant:
        plant["G"] = _scaled(str(plant["G"]), 1.05)
    elif "problem" in plant and "h" in plant:
        plant["h"] *= 1.5
    elif "A" in plant:
        first = plant["A"][0][0]  # an expression may be an entry
        larger = f"1.05*({first})" if isinstance(first, str) else 1.05 * first
        plant["A"][0][0] = first + 1 if "exact" in part else larger
    elif "a" in plant:
        plant["a"] = f"{plant['a']} + 7"
    else:
        return False
    return True


def _source(part: Table) -> bool:
    """A plant as printed in place of the corrected one, and the reverse."""
    plant = part.get("plant") or {}
    if plant.get("source") not in OTHER_SOURCE:
        return False
    plant["source"] = OTHER_SOURCE[plant["source"]]
    return True


def _transition(part: Table) -> bool:
    plant = part.get("plant") or {}
    if plant.get("problem") != "aircraft transition":
        return False
    plant["start"] = plant.get("start", 250.0) + 20.0
    return True


def _sign(part: Table) -> bool:
    plant = part.get("plant") or {}
    if "G" in plant:
        plant["G"] = f"-({plant['G']})"
    elif "B" in plant:
        plant["B"] = [[-entry for entry in row] for row in plant["B"]]
    else:
        return False
    return True


def _no_adaptation(part: Table) -> bool:
    """R_theta = 1e30: theta stays where it is."""
    controller = part.get("controller")
    if controller is None or controller.get("structure") == "lqg":
        return False
    controller["R_theta"] = 1e30
    return True


def _no_input(part: Table) -> bool:
    if "w" not in part.get("estimation", {}):
        return False
    part["estimation"]["w"] = {"white_noise": 1e-12}
    return True


def _truth(part: Table) -> bool:
    """The parameter jumps to twice its value for the last tenth of the steps."""
    estimation = part.get("estimation", {})
    if "truth" not in estimation or "steps" not in estimation:
        return False
    last = estimation["truth"][-1][1]
    estimation["truth"] = [*estimation["truth"], [estimation["steps"] * 9 // 10, 2 * last]]
    return True


def _constant_truth(part: Table) -> bool:
    """The first value of the parameter, and the first system, to the end."""
    estimation = part.get("estimation", {})
    if len({value for _, value in estimation.get("truth", [])}) < 2:
        return False
    estimation["truth"] = [[0, estimation["truth"][0][1]]]
    for name in ("A_then", "D_1_then"):
        estimation.pop(name, None)
    return True


def _target(part: Table) -> bool:
    """A target model of the other sign, or with other poles."""
    target = part.get("target", {})
    if "G_f" in target:
        target["G_f"] = f"-({target['G_f']})"
    elif isinstance(target.get("poles"), list):
        target["poles"] = [*target["poles"][:-2], "0.85", "-0.85"]
    elif target.get("model") == "fir":
        target.update({"model": "filter", "G_f": "-1/q**3"})
        for key in ("H", "d_zu", "nmp_zeros"):
            target.pop(key, None)
    else:
        return False
    return True
