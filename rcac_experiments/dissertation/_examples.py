"""The numbered examples of the dissertation, each a file that a user could have written.

Nothing is built here, so that `rcac list` waits for neither NumPy nor SymPy.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from importlib import resources

from compensator_theory.errors import InputError
from rcac_experiments.files._documents import Raw, parsed
from rcac_experiments.format._places import quoted

FOLDER = resources.files(__package__).joinpath("example_files")


def example_ids() -> list[str]:
    """The numbers of the dissertation's examples that are here, in order."""
    names = [path.name.removesuffix(".toml") for path in FOLDER.iterdir()]
    numbers = [name for name in names if not name.startswith("__")]
    return sorted(numbers, key=in_order)


def in_order(number: str) -> list[str]:
    """Sort by chapter and then by number, 2.10 after 2.9; the appendices last."""
    return [part.zfill(2) for part in number.split(".")]


def absent_examples() -> Iterator[tuple[str, str]]:
    """The numbered examples that are not here, each with the reason."""
    present = set(example_ids())
    table = tomllib.loads(FOLDER.joinpath("__absent__.toml").read_text("utf-8"))
    for entry in table["absent"]:
        for number in entry["numbers"]:
            if number not in present:
                yield number, str(entry["reason"])


def example_titles() -> Iterator[tuple[str, str]]:
    """Number and title of each example, without building anything."""
    for number in example_ids():
        yield number, str(read_example(number)[0]["title"])


def read_example(number: str) -> tuple[Raw, str]:
    """The tables of one numbered example and the name of its file."""
    return parsed(example_text(number)), number


def example_text(number: str) -> str:
    """The file of one numbered example, as it was written."""
    if number not in example_ids():
        raise InputError(
            f"there is no example {quoted(number)}; there are {', '.join(example_ids())}. "
            "For a case of your own, give the path of its TOML file."
        )
    return str(FOLDER.joinpath(f"{number}.toml").read_text("utf-8"))
