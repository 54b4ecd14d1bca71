"""The reference: every public name in one group and on one page, every equation in the index."""

import ast
from collections import Counter
from pathlib import Path

import pytest

from docs.cross_references import INVENTORIES, OF_OTHERS, intersphinx, public_target, type_links
from docs.equation_index import CHAPTERS, cited, equations, equations_page, texts
from docs.reference_pages import (
    PACKAGES,
    ROOT,
    groups,
    page_of,
    public_names,
    public_path,
    write_reference,
)
from tests.house.layers import LAYERS


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reference")
    write_reference(folder, LAYERS)
    return folder


@pytest.fixture(scope="module")
def index():
    return equations()


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_name_is_in_one_group(package):
    """The groups by task and `__all__` are the same names, each once."""
    counted = Counter(name for group in groups(package) for name in group.names)
    public = set(public_names(package))
    where = f"docs/reference_groups/{package}.toml"
    assert not public - set(counted), f"belongs to a task in {where}"
    assert not set(counted) - public, f"is in {where} and not public"
    assert not [name for name, times in counted.items() if times > 1]


def test_pages_of_groups_differ():
    pages = [group.page for package in PACKAGES for group in groups(package)]
    assert len(pages) == len(set(pages))


def test_every_public_name_has_a_page_that_its_group_links(written):
    for package in PACKAGES:
        for group in groups(package):
            table = (written / f"{group.page}.md").read_text()
            for name in group.names:
                page = page_of(package, name)
                assert f"]({page}.md)" in table
                assert f"# {public_path(package, name)}\n" in (written / f"{page}.md").read_text()


def test_pages_differ_on_every_file_system():
    """Upper and lower case are one on some: design and Design need two names."""
    pages = [
        page_of(package, name).lower() for package in PACKAGES for name in public_names(package)
    ]
    assert len(pages) == len(set(pages))


@pytest.mark.slow
def test_a_page_that_is_no_more_is_removed(tmp_path):
    (tmp_path / "api").mkdir()
    (tmp_path / "api" / "rcac_numeric.was_renamed.md").write_text("# old\n")
    write_reference(tmp_path, LAYERS)
    assert not (tmp_path / "api" / "rcac_numeric.was_renamed.md").exists()


@pytest.mark.costly
def test_every_module_is_on_the_page_of_its_folder(written):
    """But for what is public, and for the strategies, which are one page."""
    for package in PACKAGES:
        for path in (ROOT / package).rglob("[a-z]*.py"):
            *folder, module = path.relative_to(ROOT).with_suffix("").parts
            if folder[-1] != "strategies":
                page = (written / f"{'.'.join(folder)}.md").read_text()
                assert f".. automodule:: {'.'.join(folder)}.{module}\n" in page


@pytest.mark.costly
@pytest.mark.parametrize(
    ("number", "name"),
    [
        ("2.42", "rcac_numeric.UD"),
        ("4.16", "rcac_numeric.intercalated_match"),
        ("4.18", "compensator_theory.intercalated_transfer_function"),
        ("A.7", "compensator_theory.solve_riccati"),
    ],
)
def test_an_equation_leads_to_what_computes_it(index, number, name):
    assert name in index[number].names


def test_the_index_has_chapters_in_their_order_and_no_stranger(index):
    chapters = list(dict.fromkeys(number[0] for number in index))
    assert chapters == [c for c in CHAPTERS if c in chapters]
    assert all(number[0] in CHAPTERS and int(number.partition(".")[2]) > 0 for number in index)


def test_ledger_and_errata_are_in_the_index(index):
    assert any(places.ledger for places in index.values())
    assert "zero-on-the-boundary" in index["1.1"].errata
    page = equations_page(index)
    assert all(f".. equation:: {number}\n" in page for number in index)


def test_a_number_in_an_example_is_no_citation():
    """A call such as f(2.5) in code of a docstring is no equation."""
    text = '"""Of (4.7).\n\nExamples\n--------\n>>> abs(2.5)\n(2.6)\n"""\nx = f(2.7)  # (A.8)\n'
    assert [list(cited(words)) for _, words in texts(text, ast.parse(text))] == [["4.7"], ["A.8"]]


def test_every_other_project_is_a_committed_list(tmp_path):
    """Each type of another project that is a link stands in a committed list."""
    known = {
        line.split()[0]
        for path in INVENTORIES.glob("*.txt")
        for line in path.read_text().splitlines()[4:]
    }
    expected = {link.rpartition("<")[2].rstrip(">`") for link in OF_OTHERS.values() if "<" in link}
    ours = {name for name in expected if name.split(".")[0] in PACKAGES}
    assert {name.removeprefix("python:") for name in expected - ours} <= known
    for _, (path,) in intersphinx(tmp_path).values():
        assert Path(path).read_bytes().startswith(b"# Sphinx inventory version 2\n")


def test_a_class_is_a_link_by_its_name():
    """No two packages have a class of one name, so that a bare word in a type says which."""
    links = type_links()
    assert links["Budget"] == "compensator_theory.Budget"
    assert links["ExperimentBudget"] == "rcac_experiments.ExperimentBudget"
    assert links["Run"] == "rcac_numeric.Run"
    assert public_target("rcac_numeric.nowhere.Nothing", "rcac_numeric") is None
