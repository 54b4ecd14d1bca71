from ._checking import check_erratum as check_erratum
from ._load import load_example as load_example
from ._reading import find_errata as find_errata
from ._reproduction import reproduce as reproduce
