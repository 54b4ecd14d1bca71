"""What a report is made of, and how it is shown: in a terminal, as JSON."""
