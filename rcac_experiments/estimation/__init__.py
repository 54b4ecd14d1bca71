"""Estimation examples: a true system, what is estimated of it, and measures of how well."""
