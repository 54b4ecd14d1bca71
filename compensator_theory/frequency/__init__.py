"""Properties along the imaginary axis or the unit circle: norms, passivity."""
