"""Recordings and searches of the sim gap that several tests use."""
