"""Regulators and observers: is a compensator observer-based, and every form of it."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
