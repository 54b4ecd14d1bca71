"""Target models for several inputs and outputs, whose zeros have directions."""
