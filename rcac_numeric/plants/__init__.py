"""Plants as data: linear, scheduled, nonlinear, saturated."""
