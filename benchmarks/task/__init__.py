"""Measurements of task graphs and predicates."""
