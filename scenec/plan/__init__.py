"""Sampling plans of a compiled scene: the plan document and its pools of cases."""
