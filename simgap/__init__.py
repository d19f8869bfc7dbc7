"""What a simulation gets wrong against measured data, and why."""
