from .figures.regions import plot_stability_region as plot_stability_region
from .figures.runs import plot_runs as plot_runs
from .run import plot_sheet as plot_sheet
