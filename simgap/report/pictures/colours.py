"""Colours of measured, declared, extended, noise and a second engine in all pictures."""

MEASURED, DECLARED, EXTENDED, NOISE, ENGINE = "#1b1f24", "#b3261e", "#1f7a4d", "#8a929d", "#2563a8"
