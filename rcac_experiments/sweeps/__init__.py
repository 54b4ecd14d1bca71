"""Many runs of one experiment: what varies, how it is run and kept, and what came out."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
