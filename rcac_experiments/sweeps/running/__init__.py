"""Running a study over any executor, and going on after whatever stopped it."""
