"""Plants with names: equations, parameters with units, operating points, exact sampling."""
