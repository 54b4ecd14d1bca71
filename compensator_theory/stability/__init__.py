"""Stability over parameters, margins, norms, passivity; interpolation and approximation."""
