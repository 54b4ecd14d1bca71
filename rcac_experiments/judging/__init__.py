"""Claims about an experiment, their sources, and the checks that decide them."""
