"""Properties that Hypothesis tries to refute, in exact arithmetic."""
