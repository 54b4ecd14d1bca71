"""Discrete-time Riccati equations: solved, checked, or refused with the reason."""
