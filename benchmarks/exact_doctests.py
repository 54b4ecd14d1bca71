"""The doctests of the exact half where nothing else is installed, as `.ci/exact` runs them.

Examples that use NumPy, python-control, Hypothesis or Matplotlib are counted apart.
"""

import doctest
import importlib
import pkgutil
import sys
import time
import warnings

ELSEWHERE = ("numpy", "scipy", "control", "hypothesis", "matplotlib", "rcac_numeric")
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
WITHOUT = ("No module named", "pip install", "pictures need the numeric half")


def main() -> int:
    """Run them, print how many pass, and return 1 if one fails."""
    warnings.simplefilter("ignore")
    start = time.monotonic()
    package = importlib.import_module("compensator_theory")
    print(f"import: {time.monotonic() - start:.2f} s")
    passed = apart = 0
    failures: list[str] = []
    finder = doctest.DocTestFinder(exclude_empty=True)
    for found in pkgutil.walk_packages(package.__path__, "compensator_theory."):
        if found.name.startswith("compensator_theory.strategies"):
            continue
        module = importlib.import_module(found.name)
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
    seconds = time.monotonic() - start
    print(
        f"{sys.platform}, Python {sys.version.split()[0]}: {passed} examples pass, {apart} need "
        f"other packages, {len(failures)} docstrings fail; {seconds:.0f} s"
    )
    print("\n".join(failures[:5]))
    present = [name for name in ELSEWHERE if name in sys.modules]
    if present and sys.platform != "emscripten":
        print(f"imported by the exact half: {present}")
    return int(bool(failures) or passed < 600)


if __name__ == "__main__" and main():
    sys.exit("the exact half fails where it is alone")
