"""What claims and studies measure: a run with its analyses, and the measures by name."""
