"""The pictures of requests, of studies and of what an experiment file names."""
