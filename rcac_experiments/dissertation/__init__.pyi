from .checking import check_erratum as check_erratum
from .load import load_example as load_example
from .reading import find_errata as find_errata
from .reproduction import reproduce as reproduce
