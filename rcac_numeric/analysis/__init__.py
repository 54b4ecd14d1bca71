"""Analysis of loops with a fixed controller, compared with exact theory."""
