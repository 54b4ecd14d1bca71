"""Coq: its files, what it is asked of them, and what it answers."""
