"""The claims of an experiment file: what is said of a case, and the checks that decide it."""

from __future__ import annotations

from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import number, one_of
from rcac_numeric.experiments.experiment import Check, Claim
from rcac_numeric.experiments.files.sections import Section
from rcac_numeric.experiments.files.signals import real
from rcac_numeric.experiments.verdicts import VERDICTS

CHECK_KEYS = ("measure", "run", "relative_to", "statistic", "at_least", "at_most")


def claim(section: Section, main_run: str) -> Claim:
    """One table of [[claims]]."""
    recorded = section.text("verdict", "")
    if recorded:
        one_of(recorded, "verdict", VERDICTS)
    checks = section.require("checks")
    if not isinstance(checks, list) or not checks:
        raise InputError("a claim needs a list of at least one check.")
    return Claim(
        text=section.text("text"),
        claimed=section.text("claimed", ""),
        checks=tuple(_check(entry, main_run) for entry in checks),
        correction=section.text("correction", ""),
        recorded=recorded,
    )


def _check(entry: Any, main_run: str) -> Check:
    if not isinstance(entry, dict) or "measure" not in entry:
        raise InputError(f"the check {entry!r} of a claim must be a table with the key 'measure'.")
    if not {"at_least", "at_most"} & entry.keys():
        raise InputError(
            f"the check of {entry['measure']!r} needs at_least, at_most or both: a check without "
            "a bound cannot fail."
        )
    for bound in {"at_least", "at_most"} & entry.keys():
        number(entry[bound], bound)
    own = {key: value for key, value in entry.items() if key in CHECK_KEYS}
    one_of(str(own.get("statistic", "each")), "statistic", ("each", "median"))
    arguments = {
        key: real(value, "omega") if key == "omega" else value
        for key, value in entry.items()
        if key not in CHECK_KEYS
    }
    return Check(**{"run": main_run, **own}, arguments=arguments)
