"""Tests of robot descriptions: readers, writers, kinematics and masses, against tables of cases and outside judges."""

import pytest

pytest.register_assert_rewrite("tests.formats.settled")  # its checks show the values that differ
