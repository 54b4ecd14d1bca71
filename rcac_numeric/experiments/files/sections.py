"""Experiments written down in TOML: the numbered examples of the dissertation and users' own."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from compensator_theory.errors import CompensatorError, InputError

Table = dict[str, Any]

# The keys of each table; which of them fit together is decided where they are read.
KEYS: dict[str, set[str]] = {
    "": {
        "id", "title", "source", "notes", "plant", "signals", "target", "controller",
        "controllers", "saturation", "run", "runs", "claims",
    },
    "plant": {
        "problem", "G", "performance", "A", "B", "C", "D_0", "D_1", "D_2", "E_0", "E_1", "E_2",
        "changes",
    },
    "plant.changes": {
        "start", "G", "A", "B", "C", "D_0", "D_1", "D_2", "E_0", "E_1", "E_2", "gain", "delay",
        "ramp", "state_map",
    },
    "signals": {"w", "r", "d", "v"},
    "target": {
        "model", "poles", "G_f", "numerator", "denominator", "d_zu", "H", "nmp_zeros", "n_bar",
        "markov_parameters",
    },
    "controller": {
        "structure", "n_c", "k_c", "terms", "free_poles", "F", "feedback", "first_r", "taps",
        "derived", "k_w", "k_update", "k_filter", "R_theta", "R_z", "R_u", "lambda", "theta_0",
        "update", "form", "window", "step_size", "process_noise", "forgetting", "lambda_changes",
        "target_changes", "reset", "freeze", "reflect_poles", "stop_where_unsupported", "shared_u",
        "noise",
    },
    "controller.derived": {"now", "before", "pole"},
    "controller.forgetting": {"short", "long", "gain", "smallest"},
    "controller.reset": {"at", "every", "trace_below", "growth", "short", "long"},
    "saturation": {"low", "high", "rate"},
    "run": {
        "steps", "seed", "stride", "arithmetic", "repetitions", "perturbation", "expected",
    },
    "runs": {
        "name", "plant", "signals", "target", "controller", "controllers", "saturation", "run",
    },
    "claims": {"text", "claimed", "checks", "correction", "verdict"},
}  # fmt: skip
# One of several controllers: all that [controller] may say, and a target of its own.
KEYS["controllers"] = KEYS["controller"] - {"shared_u"} | {"target"}

# A run that names one of these replaces the whole table: the old keys would mean nothing to it.
KINDS = {"target": "model", "plant": "problem"}


class Section:
    """A table of the file that knows where it stands, for error messages."""

    def __init__(self, table: Any, name: str, file: str, keys: set[str] | None = None) -> None:
        self.name, self.file = name, file
        if not isinstance(table, dict):
            raise InputError(f"{file}: {self.where} must be a table, not {table!r}.")
        self.table = table
        known = KEYS[name] if keys is None else keys
        for key in table:
            if key not in known:
                close = difflib.get_close_matches(key, known, n=1)
                hint = f" Did you mean {close[0]!r}?" if close else ""
                raise InputError(
                    f"{file}: unknown key {key!r} in {self.where}.{hint} "
                    f"Known keys: {', '.join(sorted(known))}."
                )

    @property
    def where(self) -> str:
        """The table's name as the file writes it."""
        return f"[{self.name}]" if self.name else "the top level"

    def require(self, key: str) -> Any:
        """The value of a key that must be there."""
        if key not in self.table:
            raise InputError(f"{self.file}: {self.where} needs the key {key!r}.")
        return self.table[key]

    def text(self, key: str, default: str | None = None) -> str:
        """The string under a key, which must be there unless there is a default."""
        value = self.require(key) if default is None else self.get(key, default)
        if not isinstance(value, str):
            raise InputError(f"{self.where} {key} = {value!r} must be a string.")
        return value

    def tables(self, key: str) -> list[Any]:
        """The array of tables under a key; empty where there is none."""
        value = self.get(key, [])
        if not isinstance(value, list):
            raise InputError(f"{key} must be an array of tables, [[{key}]].")
        return value

    def items(self, key: str) -> list[Any]:
        """The list under a key; empty where there is none."""
        value = self.get(key, [])
        if not isinstance(value, list):
            raise InputError(f"{self.where} {key} = {value!r} must be a list.")
        return value

    def flag(self, key: str) -> bool:
        """The truth value under a key; false where there is none."""
        value = self.get(key, False)
        if not isinstance(value, bool):
            raise InputError(f"{self.where} {key} = {value!r} must be true or false.")
        return value

    def only(self, case: str, *keys: str) -> None:
        """Refuse keys that would be ignored in this case."""
        for key in self.table:
            if key not in keys:
                raise InputError(
                    f"{self.where} sets {key!r}, which {case} does not read. "
                    f"It reads {', '.join(keys)}."
                )

    def given(self, *keys: str) -> Table:
        """Those of `keys` that the file sets."""
        return {key: self.table[key] for key in keys if key in self.table}

    def get(self, key: str, default: Any) -> Any:
        """The value of a key, or a default."""
        return self.table.get(key, default)


def example_ids() -> list[str]:
    """The numbers of the dissertation's examples that are here, in order."""
    names = [path.name[: -len(".toml")] for path in _folder().iterdir() if _is_example(path.name)]
    return sorted(names, key=lambda name: [part.zfill(2) for part in name.split(".")])


def example_titles() -> Iterator[tuple[str, str]]:
    """Number and title of each example, without building anything."""
    for number in example_ids():
        text = _folder().joinpath(f"{number}.toml").read_text("utf-8")
        yield number, str(tomllib.loads(text)["title"])


def read_example(number: str) -> tuple[Table, str]:
    """The data of one numbered example and the name of its file."""
    if number not in example_ids():
        raise InputError(
            f"there is no example {number!r}; there are {', '.join(example_ids())}. "
            "For a case of your own, give the path of its TOML file."
        )
    return tomllib.loads(_folder().joinpath(f"{number}.toml").read_text("utf-8")), number


def read_file(path: str | Path) -> tuple[Table, str]:
    """The data of a user's file and its name."""
    try:
        with Path(path).open("rb") as file:
            return tomllib.load(file), str(path)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}.") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not valid TOML: {error}.") from None


def merged(base: Mapping[str, Any], override: Mapping[str, Any]) -> Table:
    """`base` with the entries of `override`, table by table.

    A run that names another target model or problem replaces that whole table: the keys of the
    old one would mean nothing to the new one.
    """
    result = dict(base)
    for key, value in override.items():
        old = result.get(key)
        if key in KINDS and isinstance(value, dict) and KINDS[key] in value:
            old = None
        result[key] = (
            merged(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
        )
    return result


def named(error: CompensatorError, file: str) -> CompensatorError:
    """The same error with the file's name in front."""
    text = str(error)
    return error if text.startswith(file) else type(error)(f"{file}: {text}")


def _folder() -> Any:
    return resources.files("rcac_numeric.experiments.dissertation")


def _is_example(name: str) -> bool:
    return name.endswith(".toml")
