"""The command rcac: one file for each of its commands."""
