"""Continua of invariant subspaces: their strata, dimensions and parametrisations."""
