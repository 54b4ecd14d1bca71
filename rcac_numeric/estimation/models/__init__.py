"""What an estimator knows of the world: linear, symbolic and Python models as data."""
