"""Commands about the dissertation as a whole: its examples, its errata."""
