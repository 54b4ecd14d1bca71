"""Every compensator that places given poles."""
