"""Tests of the MJCF reader and writer."""
