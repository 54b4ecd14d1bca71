"""The exact half stands alone: its examples run where no numeric library can be imported."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "compensator_theory"
CHAPTERS = sorted(p.name for p in PACKAGE.iterdir() if (p / "__init__.py").exists())
# An example that says one of these asks for a numeric library.
NEEDS = re.compile(
    r"\b((import|from) (control|numpy|scipy|matplotlib)|picture_of|control_state_space)\b|\.plot\("
)
ALONE = """
import doctest, importlib, json, pkgutil, sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("numpy", "scipy", "control", "matplotlib"):
            raise ModuleNotFoundError(f"there is no {name} here", name=name)

sys.meta_path.insert(0, Missing())
place = "compensator_theory" + (f".{sys.argv[1]}" if sys.argv[1] else "")
package = importlib.import_module(place)
inner = pkgutil.walk_packages if sys.argv[1] else pkgutil.iter_modules
found = [m for m in inner(package.__path__, f"{place}.") if sys.argv[1] or not m.ispkg]
names = [place, *(m.name for m in found)]
answers = {}
for name in names:
    module = importlib.import_module(name)
    for test in doctest.DocTestFinder().find(module, name):
        if test.examples:
            said = []
            flags = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
            doctest.DocTestRunner(optionflags=flags).run(test, out=said.append)
            sources = "".join(example.source for example in test.examples)
            answers[test.name] = sources, "".join(said)
print(json.dumps(answers))
"""


def answers_of(chapter):
    """(its source, what went wrong) of each example of a folder, or of what stands beside them."""
    done = subprocess.run(
        [sys.executable, "-c", ALONE, chapter], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.costly
@pytest.mark.cases(2)
@pytest.mark.parametrize("chapter", ["", *CHAPTERS], ids=lambda name: name or "beside the folders")
def test_examples_run_without_numeric_libraries(chapter):
    """Those that name one are left out; where they need none, that is found, too."""
    answers = answers_of(chapter)
    asking = {name for name, (source, _) in answers.items() if NEEDS.search(source)}
    wrong = {name: message for name, (_, message) in answers.items() if message}
    assert answers and not set(wrong) - asking, "\n".join(wrong.values())
    assert asking == set(wrong), "it needs no numeric library, and says so"
    assert len(asking) <= 1 + len(answers) // 10
