"""Experiments, their requests, and their verification."""
