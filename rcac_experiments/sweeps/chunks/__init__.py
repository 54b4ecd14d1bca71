"""What a worker does: some runs of a study, and nothing else."""
