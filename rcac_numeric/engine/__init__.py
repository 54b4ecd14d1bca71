"""The compiled step and everything that drives it; only this folder imports the kernel."""
