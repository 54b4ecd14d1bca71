"""Certificates of results as records that another program checks."""
