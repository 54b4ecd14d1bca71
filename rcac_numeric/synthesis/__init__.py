"""From a plant to a controller with reasons: reference loop, settings, verdict on held-out runs."""
