"""Canonical forms of matrices, pencils and polynomial matrices: Frobenius, Kronecker, Popov."""
