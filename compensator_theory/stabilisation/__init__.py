"""When a loop is stable: conditions on symbols, ranges of a gain, poles that must be unstable."""
