"""Exact linear algebra: systems, ranks with symbols, exponentials, invariant subspaces."""
