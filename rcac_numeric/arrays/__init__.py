"""Validation of float64 arrays, equality by value, files, text."""
