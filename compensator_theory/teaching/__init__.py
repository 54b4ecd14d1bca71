"""Exercises that say what is wrong with an answer: a counterexample of least size."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
