"""Exact examples: a plant or two polynomials, and statements that are so or are not."""
