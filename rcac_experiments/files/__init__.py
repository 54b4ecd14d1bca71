"""Experiments written down in TOML: one reader for each table."""
