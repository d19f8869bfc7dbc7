"""Inference of missing effects: fits, screening, forward selection, competing hypotheses, intervals, verdict.

Read `forward_selection.py` first (the search), then `verdict.py` (from evidence to names).
"""
