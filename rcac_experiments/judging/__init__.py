"""Claims: what is said of an experiment, whose words they are, and what decides them."""
