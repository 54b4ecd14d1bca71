import os
import sys
import tempfile
import tomllib
import warnings
from pathlib import Path

# Last: the packages are those that are installed, the ledger of proofs is that of this checkout.
sys.path.append(str(Path(__file__).resolve().parents[1]))

from docutils import nodes
from sphinx.util import logging

import rcac_experiments.dissertation
from docs.browser.pages import STATIC, setup_browser
from docs.constructions_page import FILE as CONSTRUCTIONS
from docs.constructions_page import constructions_table
from docs.cross_references import intersphinx, resolve_public, skip_foreign, type_links
from docs.equation_index import equations, equations_page
from docs.equation_links import setup_equations
from docs.errata_page import CHAPTERS, errata_page
from docs.evidence_page import evidence_table
from docs.exercises_page import exercises_page
from docs.exercises_page import sources as exercise_files
from docs.formulas import setup_formulas
from docs.notebook_pages import copy_notebooks, write_settings
from docs.numbered_items import FILE as ITEMS
from docs.numbered_items import counts, table
from docs.reference_pages import ROOT, changed, write_reference, write_rocq
from docs.thumbnails import insert_thumbnails
from rcac_experiments.explorer._page import explorer_page
from rcac_numeric.reports._rendering import write_page
from tests.house.layers import LAYERS

EXAMPLES = Path(rcac_experiments.dissertation.__file__).parent / "example_files"
REFERENCE = Path(__file__).resolve().parent / "reference"
write_reference(REFERENCE, LAYERS)
index = equations()
changed(REFERENCE / "equations.md", equations_page(index))
write_rocq(REFERENCE / "rocq")
copy_notebooks(Path(__file__).resolve().parent / "notebooks")

# SymPy's own docstrings, which are read on the way to ours.
warnings.filterwarnings("ignore", message="Unknown section .*sympy", category=UserWarning)

project = "compensator-theory"
author = "The compensator-theory developers"
copyright = "2026, the compensator-theory developers"
extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.intersphinx",
    "sphinx_copybutton",
    "sphinx_design",
]
source_suffix = {".md": "myst-nb"}
exclude_patterns = ["_build", "_static", "jupyter_execute"]  # what a build leaves behind
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
smartquotes_action = "De"  # dashes and dots; a quote after a letter is a transpose

# A page with code cells runs whenever it is read, in a folder of its own, so that what it prints is
# what today's code prints; a cell that fails fails the build.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 600  # of a cell that hangs; a busy machine takes its time
nb_merge_streams = True
# Figures as a notebook shows them, twice as fine; and no setting of whoever builds.
os.environ["IPYTHONDIR"] = write_settings(Path(tempfile.mkdtemp()))
# Their matrices are small: several threads wait for each other, where other work shares the cores.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# What is not in a wheel and some pages read: examples and the ledger.
os.environ["CHECKOUT"] = str(ROOT)

html_theme = "furo"
html_math_renderer = "mathml"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
if repository := PROJECT.get("urls", {}).get("Repository"):
    html_theme_options = {
        "source_repository": repository, "source_branch": "main", "source_directory": "docs/",
    }  # fmt: skip
html_title = "compensator-theory"
html_static_path = ["_static", STATIC]
html_css_files = ["pictures.css"]
html_js_files = [(name, {"defer": "defer"}) for name in ("reachable.js", "search_words.js")]
# The explorer, which is built with the pages: _static/explorer.html.
explorer_folder = Path(tempfile.mkdtemp())
html_static_path.append(str(explorer_folder))
html_search_scorer = str(Path(__file__).resolve().parent / "search_scorer.js")
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

autodoc_member_order = "bysource"
autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_ignore = "all"  # of the words of a type, those of this list are links and no others
numpydoc_xref_aliases = type_links()
nitpicky = True
intersphinx_mapping = intersphinx(REFERENCE / "inventories")
equation_numbers = frozenset(index)


def build_explorer(app):
    """Build the explorer, or say by name what is missing for it."""
    from compensator_theory.errors import InputError

    try:
        write_page(explorer_page(), explorer_folder / "explorer.html")
    except InputError as error:
        logging.getLogger(__name__).warning("the explorer is not among the pages: %s", error)


def insert_ledger(app, name, source):
    """Write the ledger of proofs where its page asks for it."""
    if name == "proofs":
        from proofs.formal.rocq_sources import sources
        from proofs.ledger.ledger import STATEMENTS, ledger
        from proofs.output import blueprint
        from proofs.output.coverage import FILE, coverage, numbers, table
        from proofs.output.page import page

        for path in (*STATEMENTS.glob("*.toml"), *sources(), FILE):
            app.env.note_dependency(str(path))
        carried = {
            entry.name: list(
                dict.fromkeys(
                    pair
                    for number in numbers(entry.source)
                    if number in index
                    for pair in index[number].errata.items()
                )
            )
            for entry in ledger()
        }
        used = [n for n, at in index.items() if at.names or at.modules or at.kernel]
        names = {n: list(at.names) for n, at in index.items()}
        for mark, text in (
            ("ledger", page(ledger(), carried)),
            ("graph", blueprint.graph(ledger())),
            ("coverage", table(coverage(used, ledger()), names)),
            ("definitions", blueprint.definitions()),
            ("answers", evidence_table()),
        ):
            source[0] = source[0].replace(f"<!-- the {mark} -->", text)


def insert_errata(app, name, source):
    """Write the errata where their page asks for them."""
    if name == "errata":
        for path in CHAPTERS.glob("*.toml"):
            app.env.note_dependency(str(path))
        source[0] = source[0].replace("<!-- the errata -->", errata_page())


def insert_file_tables(app, name, source):
    """Write the tables of keys into the page of experiment files."""
    if name == "experiment-files":
        from rcac_experiments.files._reference import page_with_tables

        source[0] = page_with_tables(source[0])


def insert_constructions(app, name, source):
    """Write the table of named constructions where its page asks for it."""
    if name == "constructions":
        app.env.note_dependency(str(CONSTRUCTIONS))
        source[0] = source[0].replace("<!-- the constructions -->", constructions_table())


def insert_exercises(app, name, source):
    """Write the tables of exercises where their page asks for them."""
    if name == "exercises":
        for path in exercise_files():
            app.env.note_dependency(str(path))
        source[0] = source[0].replace("<!-- the exercises -->", exercises_page())


def insert_judging(app, name, source):
    """Write where every numbered item stands, and how many claims have which verdict."""
    if name == "fair-judging":
        for path in (ITEMS, *EXAMPLES.glob("*.toml"), *CHAPTERS.glob("*.toml")):
            app.env.note_dependency(str(path))
        source[0] = source[0].replace("<!-- the numbered items -->", table())
        source[0] = source[0].replace("<!-- the counts -->", counts())


def stack_tables(app, tree, page):
    """Let the tables of the reference stand name above sentence on a narrow screen."""
    if page.startswith("reference/"):
        for table in tree.findall(nodes.table):
            if len(list(table.findall(nodes.colspec))) == 2:
                table["classes"].append("stacked")


def keep_only_the_page(app, tree):
    """Let go of what `eval-rst` parsed apart, whose settings would keep the whole environment."""
    for node in tree.findall():
        node.document = tree


def setup(app):
    setup_equations(app)
    setup_formulas(app)
    setup_browser(app)
    app.connect("doctree-read", keep_only_the_page)
    app.connect("builder-inited", build_explorer)
    app.connect("doctree-resolved", insert_thumbnails)
    app.connect("doctree-resolved", stack_tables)
    app.connect("autodoc-skip-member", skip_foreign)
    app.connect("missing-reference", resolve_public)
    app.connect("source-read", insert_ledger)
    app.connect("source-read", insert_errata)
    app.connect("source-read", insert_constructions)
    app.connect("source-read", insert_exercises)
    app.connect("source-read", insert_file_tables)
    app.connect("source-read", insert_judging)
