"""Gate rules on collision shapes: presence, convexity, fit to the visible surface, contact materials."""
