"""Geometric control: controlled invariant subspaces, decoupling, fixed modes."""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub("compensator_theory", __file__)
