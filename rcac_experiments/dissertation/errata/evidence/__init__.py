"""Checks of the errata: what is printed fails, and what is said to be true holds."""
