"""Threads do not change each other's results, nor what belongs to the whole process."""

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.costly
def test_eight_threads_answer_what_one_does():
    root = Path(__file__).parents[2]
    command = [sys.executable, "-W", "error", "-m", "tests.support.thread_mix", "2"]
    out = subprocess.run(command, capture_output=True, text=True, check=False, cwd=root)
    assert out.returncode == 0, out.stderr[-3000:]
    assert int(out.stdout) >= 8 * 18  # every task in every thread
