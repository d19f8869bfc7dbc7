"""Effects of a robot's own controller."""
