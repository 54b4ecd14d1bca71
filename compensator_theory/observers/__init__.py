"""Regulators and observers: is a compensator observer-based, and every form of it."""
