"""Tosses: boxes that fly or slide, as cases of the suite."""
