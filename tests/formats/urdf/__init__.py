"""Tests of the URDF reader and writer."""
