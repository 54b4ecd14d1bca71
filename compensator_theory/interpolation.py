"""Rational functions from data: Laurent and Padé, partial realisations, Nevanlinna-Pick."""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub("compensator_theory", __file__)
