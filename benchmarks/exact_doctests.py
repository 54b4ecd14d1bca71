"""The doctests of the exact half where nothing else is installed, as `.ci/exact` runs them.

Examples that use NumPy, python-control, Hypothesis or Matplotlib are counted apart. The file
`pages.json` beside this one has the examples that the docs run in a reader's browser, by page.
"""

import contextlib
import doctest
import importlib
import io
import json
import pkgutil
import sys
import time
import warnings
from pathlib import Path

ELSEWHERE = ("numpy", "scipy", "control", "hypothesis", "matplotlib", "rcac_numeric")
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
WITHOUT = ("No module named", "pip install", "pictures need the numeric half")


def main() -> int:
    """Run them, print how many pass, and return 1 if one fails."""
    warnings.simplefilter("ignore")
    start = time.monotonic()
    package = importlib.import_module("compensator_theory")
    print(f"import: {time.monotonic() - start:.2f} s")
    passed = apart = passed_pages = 0
    failures: list[str] = []
    finder = doctest.DocTestFinder(exclude_empty=True)
    for info in pkgutil.walk_packages(package.__path__, "compensator_theory."):
        if info.name.startswith("compensator_theory.strategies"):
            continue
        module = importlib.import_module(info.name)
        for test in finder.find(module, module.__name__, module=module):
            written: list[str] = []
            runner = doctest.DocTestRunner(verbose=False, optionflags=FLAGS)
            result = runner.run(test, out=written.append)
            text = "".join(written)
            if result.failed and any(words in text for words in WITHOUT):
                apart += result.attempted
            elif result.failed:
                failures.append(text)
            else:
                passed += result.attempted
    pages = json.loads(Path("pages.json").read_text("utf-8"))
    for page, examples in pages.items():
        text = failure_of_page(examples)
        if text and not any(words in text for words in WITHOUT):
            failures.append(f"{page}: {text}")
        elif not text:
            passed_pages += 1
    seconds = time.monotonic() - start
    print(
        f"{sys.platform}, Python {sys.version.split()[0]}: {passed} examples pass, {apart} need "
        f"other packages; {passed_pages} of {len(pages)} pages pass; {len(failures)} docstrings "
        f"and pages fail; {seconds:.0f} s"
    )
    print("\n".join(failures[:5]))
    present = [name for name in ELSEWHERE if name in sys.modules]
    if present and sys.platform != "emscripten":
        print(f"imported by the exact half: {present}")
    return int(bool(failures) or passed < 600)


def failure_of_page(examples: list[str]) -> str:
    """What is wrong with the examples of a page, sessions or code, run in their order."""
    names = {"__name__": "__main__"}
    runner = doctest.DocTestRunner(verbose=False, optionflags=FLAGS)
    written: list[str] = []
    for example in examples:
        if ">>> " in example:
            session = doctest.DocTestParser().get_doctest(example, names, "example", None, None)
            names = session.globs
            runner.run(session, out=written.append, clear_globs=False)
            continue
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(example, "<example>", "exec"), names)
        except Exception as error:
            written.append(f"{type(error).__name__}: {error}")
    return "".join(written)


if __name__ == "__main__" and main():
    sys.exit("the exact half fails where it is alone")
