"""Benchmark plants: equations, parameters with units, operating points, exact sampling."""
