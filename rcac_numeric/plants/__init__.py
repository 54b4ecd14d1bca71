"""What is controlled, as data: linear, scheduled, nonlinear, saturated."""
