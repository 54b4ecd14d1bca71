"""Exact compensator theory: what a dynamic compensator can do to the closed-loop poles.

Integers, rationals and symbols; never a float, never a tolerance. Loops of chapters 2 and 4
(:class:`StandardProblem`, the intercalated transfer function) use positive feedback, ``u = G_c y``;
:func:`place_poles` asks for the sign.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
