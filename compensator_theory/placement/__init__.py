"""Pole placement: compensators, gains, factorisations, geometric control."""
