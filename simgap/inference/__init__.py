"""Inference of missing effects: fits, screening, forward selection, competing hypotheses, intervals, verdict."""
