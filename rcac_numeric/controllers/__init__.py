"""Controllers as data: structures, updates, forgetting, supervision, fixed compensators."""
