"""Simulation engine: runs, batches, controllers, states, reference arithmetic."""
