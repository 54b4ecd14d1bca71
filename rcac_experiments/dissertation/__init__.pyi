from .errata.checking import check_erratum as check_erratum
from .errata.reading import find_errata as find_errata
from .load import load_example as load_example
from .reproduction import reproduce as reproduce
