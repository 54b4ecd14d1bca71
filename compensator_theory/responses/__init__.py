"""Responses in time as closed forms, transition matrices, characteristics of a step response."""
