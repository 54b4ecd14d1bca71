"""Hypothesis profiles: `dev` by default, `ci` for the check, `fresh` and `thorough` for hunts.

Choose with HYPOTHESIS_PROFILE=ci. All but `ci` draw anew in every run; `--hypothesis-seed` and
`--randomly-seed` repeat the draws and the order of another. `--long` runs the marked long
statistics in full, and all that is marked slow, `--slow N` runs N of these. Where the whole suite
is run, one in twenty of the tests marked `costly` is, others in every run; `--costly N` runs one
in N, and `.ci/run` one in ten. Of a test marked `cases(N)` N of its cases are run, others in every
run, and all with `--all-cases`, as in `.ci/run`, or `--long`; `--perturb SEED` moves the last
digits of all data, but in tests marked `exact_data`.
"""

import gc
import os
import random
import signal
import sys
from collections import defaultdict

for library in ("OPENBLAS", "MKL", "OMP"):  # matrices are small, and the workers share the cores
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
# Images of containers set it: hundreds of tests start a Python, and each would compile all again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

import hypothesis  # noqa: E402
import pytest  # noqa: E402

from tests.support.last_digits import LastDigits  # noqa: E402

hypothesis.settings.register_profile("dev", max_examples=7, deadline=None)
hypothesis.settings.register_profile("ci", max_examples=10, deadline=None, derandomize=True)
hypothesis.settings.register_profile("fresh", max_examples=30, deadline=None, print_blob=True)
hypothesis.settings.register_profile("thorough", max_examples=1000, deadline=None)
hypothesis.settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "dev"))


def pytest_addoption(parser):
    parser.addoption("--long", action="store_true", help="run the long statistics in full")
    parser.addoption("--slow", type=int, default=0, metavar="N", help="run N of the slow tests")
    parser.addoption(
        "--costly", type=int, default=20, metavar="N", help="run one in N of the costly"
    )
    parser.addoption("--all-cases", action="store_true", help="run every case of every test")
    parser.addoption("--perturb", type=int, metavar="SEED", help="move the last digits of all data")


WHOLE_SUITE = 3000  # more tests than any folder has
LAST_DIGITS = pytest.StashKey[LastDigits]()


def pytest_configure(config):
    """Before any test imports what it tests."""
    seed = config.getoption("--perturb")
    if seed is not None:
        config.stash[LAST_DIGITS] = LastDigits(seed)
        config.stash[LAST_DIGITS].install()


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Modules, libraries and tests stay to the end: a search for garbage among them is in vain.

    They are not frozen: `benchmarks/verb_mutants.py` looks for functions by `gc.get_objects`.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """A documented example prints what it was given; a test of exact data is about its digits."""
    if last_digits := item.config.stash.get(LAST_DIGITS, None):
        documented = isinstance(item, pytest.DoctestItem)
        last_digits.active = not documented and not item.get_closest_marker("exact_data")


@pytest.hookimpl(trylast=True)  # of what -k leaves
def pytest_collection_modifyitems(config, items):
    """What is slow is for --long; what a supervisor says of a drawn controller is no failure."""
    if not config.getoption("--long"):
        draw = random.Random(_seed(config))
        left = _not_drawn(draw, items, "slow", lambda _: config.getoption("--slow"))
        if len(items) > WHOLE_SUITE:
            left |= _not_drawn(draw, items, "costly", lambda n: n // config.getoption("--costly"))
        if not config.getoption("--all-cases"):
            left |= _other_cases(items, draw)
        config.hook.pytest_deselected(items=[i for i in items if i.nodeid in left])
        items[:] = [i for i in items if i.nodeid not in left]
    warning = "ignore::rcac_numeric.controllers._supervision.SupervisionWarning"
    for item in items:
        if getattr(getattr(item, "obj", None), "is_hypothesis_test", False):
            item.add_marker(pytest.mark.filterwarnings(warning))


def _seed(config):
    """One for all workers, so that they agree on what is drawn."""
    workers = getattr(config, "workerinput", {})
    return config.getoption("randomly_seed", None) or workers.get("testrunuid")


def _not_drawn(draw, items, marker, number):
    """What is left out of the tests with a marker, of which `number` of their count are run."""
    marked = sorted(item.nodeid for item in items if item.get_closest_marker(marker))
    return set(marked) - set(draw.sample(marked, min(number(len(marked)), len(marked))))


def _other_cases(items, draw):
    """What is not drawn of tests with many cases; a case that is asked for by its name is run."""
    left, groups = set(), defaultdict(list)
    for item in items:
        if marker := item.get_closest_marker("cases"):
            groups[item.nodeid.partition("[")[0], *marker.args].append(item.nodeid)
    for (_, number), cases in sorted(groups.items()):
        left |= set(cases) - set(draw.sample(sorted(cases), min(number, len(cases))))
    return left


@pytest.fixture
def in_full(request):
    """Whether a long statistic runs in full or in reduced form."""
    return request.config.getoption("--long")


@pytest.fixture
def at_a_terminal():
    """Ctrl-C as it comes to a program at a terminal, here and in what the test starts.

    A shell starts what runs in its background with SIGINT ignored, and every child inherits that.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
