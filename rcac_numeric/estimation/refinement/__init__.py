"""Retrospective cost model refinement: subsystems that no sensor sees, and parameters as such."""
