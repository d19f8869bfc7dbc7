"""Inference on whole trials: models fitted with every trial's start free, ranked by trials that taught them nothing.

Read `search_models.py` first (null, one effect, two ...), then `confidence_set.py` (which models cannot be rejected).
"""
