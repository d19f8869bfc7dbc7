"""Mechanisms that tests draw or build, and link poses by outside readers."""
