"""Identities of letters: matrices of any size, or polynomials with generic coefficients."""
