"""Where roots lie for which parameters: conditions, regions, margins, norms, interpolation."""
