"""Canonical forms of polynomial matrices, pencils and matrices: Hermite to Frobenius."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
