"""Chunks are read in this process, as in the tests of sweeps."""

from tests.rcac_experiments.sweeps.conftest import in_this_process

__all__ = ["in_this_process"]
