from ._requested import plot_request as plot_request
