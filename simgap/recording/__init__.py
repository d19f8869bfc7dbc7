"""Measurements: reading a folder of recordings, its checks, and the split into training and test trials."""
