"""The pages of docs/guide and docs/coming-from: listed, captioned, and right in what they print.

The pages that hold an update of another program against ours run here by default, all with --long;
the docs build runs every cell of every page in any case.
"""

import ast
import re
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

DOCS = Path(__file__).resolve().parents[2] / "docs"
FOLDERS = ("guide", "coming-from")
PAGES = sorted(page for folder in FOLDERS for page in (DOCS / folder).glob("*.md"))
COMPARED = ("pyrcac", "rcac-cpp", "px4", "matlab")
CELL = re.compile(
    r"^```\{code-cell\} python\n(?P<head>---\n.*?^---\n)?(?P<code>.*?)^```", re.S | re.M
)


def cells(page):
    """The options and the code of each cell; magics and lines of options left out."""
    for result in CELL.finditer(page.read_text()):
        lines = result["code"].splitlines()
        yield (
            result["head"] or "",
            "\n".join(line for line in lines if not line.startswith((":", "%"))),
        )


def figures_of(page, folder, monkeypatch):
    """Run a page in a folder of its own; its names, and for each cell the figures that it shows."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("CHECKOUT", str(DOCS.parent))
    names, shown = {}, []
    for head, code in cells(page):
        tree = ast.parse(code)
        last = None
        if tree.body and isinstance(tree.body[-1], ast.Expr):
            last = compile(ast.Expression(tree.body.pop().value), page.name, "eval")
        exec(compile(tree, page.name, "exec"), names)
        value = None if last is None else eval(last, names)
        figures = [plt.figure(number) for number in plt.get_fignums()]
        if isinstance(value, Figure) and value not in figures:
            figures.append(value)
        shown.append((head, figures))
        plt.close("all")
    return names, shown


def require_labels(figure):
    """Every axes of a figure has labels on both axes, its own or those that it shares."""
    for axis in figure.axes:
        if axis.get_label() == "<colorbar>":
            continue
        for group, label in (
            (axis.get_shared_x_axes(), Axes.get_xlabel),
            (axis.get_shared_y_axes(), Axes.get_ylabel),
        ):
            shared = [axis, *(other for other in figure.axes if group.joined(axis, other))]
            assert any(label(other) for other in shared)


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_page_is_in_the_contents_of_its_folder(folder):
    index = (DOCS / folder / "index.md").read_text()
    contents = index.split("{toctree}")[1].split("```")[0].split()
    pages = {page.stem for page in (DOCS / folder).glob("*.md")} - {"index"}
    assert {entry for entry in contents if not entry.startswith(":")} == pages


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_are_short(page):
    assert len(page.read_text().splitlines()) < 330


@pytest.mark.costly
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_run_and_their_figures_have_labels_and_captions(page, in_full, tmp_path, monkeypatch):
    if not in_full and page.stem not in COMPARED:
        pytest.skip("with --long; the docs build runs it")
    names, shown = figures_of(page, tmp_path, monkeypatch)
    for head, figures in shown:
        assert not figures or "caption:" in head
        for figure in figures:
            require_labels(figure)
    if page.stem in COMPARED:
        require_agreement(page.stem, names)


def require_agreement(page, names):
    """theta of the other program's update, as the page writes it out, is ours to rounding."""
    if page == "pyrcac":  # a covariance update in float64 keeps fewer digits the smaller R0 is
        bounds = {1e2: 1e-13, 1.0: 1e-13, 1e-2: 1e-11, 1e-4: 1e-8, 1e-6: 1e-6}
        for R0, bound in bounds.items():
            assert names["differences"][R0, "UD"] < bound
    elif page == "rcac-cpp":
        assert np.abs(names["run"].theta - names["theta"]).max() < 1e-11
        assert np.abs(names["z"]).max() > 0.1
    elif page == "px4":
        assert len(names["pairs"]) == 6
        for (theta, z), (our_theta, our_z) in names["pairs"].values():
            assert np.abs(theta - our_theta).max() < 1e-11 * np.abs(theta).max()
            assert np.abs(z - our_z).max() < 1e-11
    else:
        for gaps in names["gaps"].values():
            assert gaps.max() < 1e-2
            assert gaps[-1] < 1e-5
