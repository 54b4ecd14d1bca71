from ._regions import plot_stability_region as plot_stability_region
from ._run import plot_sheet as plot_sheet
from ._runs import plot_runs as plot_runs
