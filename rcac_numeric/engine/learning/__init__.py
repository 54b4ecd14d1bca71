"""Runs that learn about their plant from their own data."""
