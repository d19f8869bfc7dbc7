"""Sampling plans of a compiled scene: the plan document (`document`), its pools (`pools`) and their cases (`cases`)."""
