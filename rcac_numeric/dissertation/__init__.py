"""The dissertation: its numbered examples, its errata, and all of them on one page."""
