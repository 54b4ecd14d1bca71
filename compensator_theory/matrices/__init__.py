"""Exact linear algebra, Sylvester matrices and invariant subspaces."""
