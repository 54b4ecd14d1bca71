"""What everything stands on: float64 arrays read and checked, equality by value, files, words."""
