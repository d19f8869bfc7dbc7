"""Suite 2: hidden effects from a generator that shares no code with the finder, scored from files alone."""
