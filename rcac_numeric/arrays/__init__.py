"""Float64 arrays as users give them, read and checked."""
