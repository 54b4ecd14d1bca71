"""The parts of :mod:`compensator_theory.strategies`."""
