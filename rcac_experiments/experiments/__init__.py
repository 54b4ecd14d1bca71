"""Experiments, what is asked of them, and their verification."""
