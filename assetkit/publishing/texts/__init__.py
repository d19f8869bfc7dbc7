"""Texts of licences that must go along with what they cover; those of Creative Commons are named by address."""
