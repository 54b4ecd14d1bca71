from .figures.regions import plot_stability_region as plot_stability_region
from .figures.requested import plot_request as plot_request
from .figures.runs import plot_runs as plot_runs
from .run import plot_sheet as plot_sheet
