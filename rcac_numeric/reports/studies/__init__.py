"""What is said of studies and of their runs."""
