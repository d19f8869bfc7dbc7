"""Tests of `gate`; seeded defects are in `tests/suites/gate`."""
