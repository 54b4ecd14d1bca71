"""The searches that the built docs are held to: each names pages that there are."""

import re
import tomllib
from pathlib import Path

import pytest

from docs.reference_pages import PACKAGES, groups, page_of
from rcac_experiments.cli._main import COMMANDS

FOLDER = Path(__file__).resolve().parent
DOCS = FOLDER.parents[1] / "docs"
SEARCHES = {
    name: tomllib.loads((FOLDER / f"{name}.toml").read_text())
    for name in ("searches", "searches_kept_back")
}


def pages():
    """Every page by its name: those written, and those made of the packages."""
    for path in DOCS.rglob("*.md"):
        if path.relative_to(DOCS).parts[0] not in ("_build", "reference", "jupyter_execute"):
            yield path.relative_to(DOCS).with_suffix("").as_posix()
    for package in PACKAGES:
        for group in groups(package):
            yield f"reference/{group.page}"
            yield from (f"reference/{page_of(package, name)}" for name in group.names)


@pytest.mark.parametrize("name", SEARCHES)
def test_what_is_to_be_found_is_there(name):
    there = set(pages())
    expected = {page for result in SEARCHES[name].values() for page in result}
    assert expected <= there, expected - there


def test_there_are_sixty():
    assert len(SEARCHES["searches"]) == 60
    assert all(SEARCHES["searches"].values()) and all(SEARCHES["searches_kept_back"].values())


@pytest.mark.parametrize("package", PACKAGES)
def test_index_terms_are_of_names_of_their_group(package):
    for group in groups(package):
        assert set(group.named) <= set(group.names), group.page


def test_the_page_of_the_command_line_has_every_command():
    rows = re.findall(r"^\| `rcac (\w+)` \|", (DOCS / "command-line.md").read_text(), re.M)
    assert sorted(rows) == sorted(COMMANDS)
