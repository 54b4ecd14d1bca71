"""The compiled step and everything that drives it."""
