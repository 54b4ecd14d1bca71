"""What adapts, as data: structures, updates, rules; and the fixed compensator."""
