"""Identification while the loop runs: recursive ARX, its zeros, and what they carry."""
