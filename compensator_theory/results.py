"""Result classes of the exact functions: solutions, forms, decisions, with certificates.

Nobody constructs them: they are here to be named in annotations and to be read about. Each is
imported when it is first used.
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub("compensator_theory", __file__)
