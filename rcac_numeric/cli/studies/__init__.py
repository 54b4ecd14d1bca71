"""The commands that run studies and look at what they came to."""
