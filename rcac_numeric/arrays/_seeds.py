"""Random seeds of the test runs."""

JUDGING = 1_000_000  # first test seed: no setting and no bound was tuned with it
