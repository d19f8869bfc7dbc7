"""Effects of sensors on what a log holds: bias, scale, latency, clock skew, rotated frames, age of velocities."""
