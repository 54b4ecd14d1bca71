"""What shows the results of this package: the entries beside the table of rcac_numeric."""

from rcac_experiments.reports import _displays as displays
from tests.support.displays import entries_of, standing_of

test_an_entry_takes_the_type_that_it_stands_for = entries_of(displays)
test_every_result_that_asks_the_table_stands_in_it = standing_of(("rcac_experiments",), displays)
