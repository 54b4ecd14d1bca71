"""A study as data: what varies, what is measured, and what each run is."""
