"""Tests of robot descriptions: readers, writers, kinematics and masses, against tables of cases and outside judges."""
