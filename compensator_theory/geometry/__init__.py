"""Geometric control: controlled invariant subspaces, decoupling, fixed modes."""
