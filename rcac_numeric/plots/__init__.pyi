from .regions import plot_stability_region as plot_stability_region
from .run import plot_sheet as plot_sheet
from .runs import plot_runs as plot_runs
