"""Many experiments in one go: run, kept as they are done, and written as one page."""
