"""Where roots are, with certificates: counts, enclosures, stability, spectral factors."""
