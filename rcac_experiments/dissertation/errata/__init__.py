"""Where the dissertation's text is wrong, what is true, and how that is known."""
