"""What the reader of a report must not miss: is the loop healthy, and if not, what to try next."""
