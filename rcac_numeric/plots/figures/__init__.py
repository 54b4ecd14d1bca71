"""Figures of examples and of runs, each answering one question."""
