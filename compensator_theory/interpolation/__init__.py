"""Rational functions from data: Pade approximants, partial realisations, Nevanlinna and Pick."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
