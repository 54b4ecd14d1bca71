"""Rational functions from data: Pade approximants, partial realisations, Nevanlinna and Pick."""
