"""Plants, runs and claims as data, and the verdicts computed from them."""
