"""Canonical forms of matrices of polynomials, and the structure of systems that they show."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
