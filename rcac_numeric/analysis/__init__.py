"""What a fixed controller does to a loop, held against exact theory."""
