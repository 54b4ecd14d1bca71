"""From a plant to a controller with reasons."""
