"""Exact sampling of continuous plants: holds of order zero and one, Tustin, matched poles."""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub("compensator_theory", __file__)
