"""Exact numbers and polynomials from text, numbers and expressions."""
