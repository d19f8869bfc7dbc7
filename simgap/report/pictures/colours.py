"""Colours of measured, declared, extended and noise in all pictures."""

MEASURED, DECLARED, EXTENDED, NOISE = "#1b1f24", "#b3261e", "#1f7a4d", "#8a929d"
