"""Hypothesis profiles: `dev` by default, `ci` for the check, `thorough` for long hunts.

Choose with HYPOTHESIS_PROFILE=ci. Every run draws anew; `--hypothesis-seed` and `--randomly-seed`
repeat the draws and the order of another. `--long` runs the marked long statistics in full.
"""

import os
import signal

import hypothesis
import pytest

hypothesis.settings.register_profile("dev", max_examples=30, deadline=None)
hypothesis.settings.register_profile("ci", max_examples=60, deadline=None, print_blob=True)
hypothesis.settings.register_profile("thorough", max_examples=1000, deadline=None)
hypothesis.settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "dev"))


def pytest_addoption(parser):
    parser.addoption("--long", action="store_true", help="run the long statistics in full")


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
