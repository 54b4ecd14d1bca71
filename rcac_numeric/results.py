"""Classes of the results of numeric functions: analyses, costs, margins, checks, tables.

Nobody constructs them: they are here to be named in annotations and to be read about. Each is
imported when it is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub("rcac_numeric", __file__)
