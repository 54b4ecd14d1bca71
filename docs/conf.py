import sys
from pathlib import Path

# Last: the packages are those that are installed, the ledger of proofs is that of this checkout.
sys.path.append(str(Path(__file__).resolve().parents[1]))
sys.path.append(str(Path(__file__).resolve().parent))

from errata_page import CHAPTERS, errata_page
from reference_pages import write_reference

from tests.house.layers import LAYERS

write_reference(Path(__file__).resolve().parent / "reference", LAYERS)

project = "compensator-theory"
author = "The compensator-theory developers"
copyright = "2026, the compensator-theory developers"
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "sphinx_design",
]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
source_suffix = {".md": "myst-nb"}
# A page with code cells runs whenever it is read, in a folder of its own, so that what it prints is
# what today's code prints; a cell that fails fails the build.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
exclude_patterns = ["_build"]
smartquotes_action = "De"  # dashes and dots; a quote after a letter is a transpose
html_theme = "furo"
html_title = "compensator-theory"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_use_rtype = False
suppress_warnings = ["ref.python"]


def insert_ledger(app, name, source):
    """Write the ledger of proofs where its page asks for it."""
    if name == "proofs":
        from proofs.formal.rocq_sources import sources
        from proofs.ledger.ledger import STATEMENTS, ledger
        from proofs.output.page import page

        for path in (*STATEMENTS.glob("*.toml"), *sources()):
            app.env.note_dependency(str(path))
        source[0] = source[0].replace("<!-- the ledger -->", page(ledger()))


def insert_errata(app, name, source):
    """Write the errata where their page asks for them."""
    if name == "errata":
        for path in CHAPTERS.glob("*.toml"):
            app.env.note_dependency(str(path))
        source[0] = source[0].replace("<!-- the errata -->", errata_page())


def setup(app):
    app.connect("source-read", insert_ledger)
    app.connect("source-read", insert_errata)
