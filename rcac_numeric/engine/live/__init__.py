"""What is changed in a controller while it runs."""
