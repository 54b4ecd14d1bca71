"""Settings of a design, tuned by simulation: in threads, or in processes with a store."""
