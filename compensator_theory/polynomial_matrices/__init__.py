"""Matrices of polynomials, in one variable or in the symbols, and elimination in them."""
