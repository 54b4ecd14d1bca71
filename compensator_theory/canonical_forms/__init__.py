"""Canonical forms of polynomial matrices, pencils and matrices: Hermite to Frobenius."""
