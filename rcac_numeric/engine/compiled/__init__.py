"""From plants, updates and controllers as data to objects of the kernel."""
