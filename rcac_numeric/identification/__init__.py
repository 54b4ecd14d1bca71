"""Markov parameters and realisations identified from data, and what targets need of them."""
