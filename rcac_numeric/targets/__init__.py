"""Target models G_f: from modelling information, poles, Markov parameters, zero directions, LQG."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
