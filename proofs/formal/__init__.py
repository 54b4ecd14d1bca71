"""The formal part: files of Coq, questions to Coq, and its answers."""
