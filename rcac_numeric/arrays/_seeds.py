"""The seeds on which results are judged."""

JUDGING = 1_000_000  # the first seed that no setting and no bound was chosen by
