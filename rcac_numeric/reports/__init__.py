"""What is said of a result, and how: in the terminal, as JSON."""
