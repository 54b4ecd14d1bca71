"""The exact half runs where NumPy, SciPy and python-control are not installed."""

import subprocess
import sys

ABSENT = ("numpy", "scipy", "control")
PICTURES = {
    "compensator_theory.responses._time_responses.TimeResponse.plot",
    "compensator_theory.systems._transfer_functions.TransferFunction.plot",
    "compensator_theory.systems._delayed_transfer_functions.DelayedTransferFunction.plot",
    "compensator_theory.stability._nearest_margins.PhaseMargins.plot",
    "compensator_theory.stability._root_locus.RootLocus.plot",
}
"""Examples that ask rcac_numeric, which needs NumPy, to draw."""
SCRIPT = f"""
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {ABSENT!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Absent())
import compensator_theory, doctest, importlib, pkgutil, hypothesis
hypothesis.settings.register_profile(
    "examples", derandomize=True, suppress_health_check=list(hypothesis.HealthCheck))
hypothesis.settings.load_profile("examples")
places = pkgutil.walk_packages(compensator_theory.__path__, "compensator_theory.")
modules = [importlib.import_module(place.name) for place in places]
flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
tried = 0
for module in modules:
    for test in doctest.DocTestFinder(exclude_empty=True).find(module):
        if test.examples and (sys.argv[1] == "all" or hash(test.name) % 8 == 0):
            tried += 1
            runner = doctest.DocTestRunner(optionflags=flags)
            if runner.run(test, out=lambda words: None).failed:
                print(test.name)
print(tried, len(set({ABSENT!r}) & set(sys.modules)))
"""


def test_every_example_but_pictures_runs_without_them(in_full):
    """An eighth of the examples, another one in each run; all of them with `--long`."""
    chosen = "all" if in_full else "some"
    ended = subprocess.run(
        [sys.executable, "-c", SCRIPT, chosen], capture_output=True, text=True, check=True
    )
    *failed, last = ended.stdout.splitlines()
    tried, loaded = map(int, last.split())
    assert not set(failed) - PICTURES and not loaded
    assert tried > (200 if in_full else 5)
    assert not in_full or set(failed) == PICTURES
