"""Pictures of results; no result imports them but inside its method plot."""
