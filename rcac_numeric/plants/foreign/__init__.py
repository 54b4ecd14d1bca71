"""Systems of python-control, SciPy and SymPy as plants of ours."""
