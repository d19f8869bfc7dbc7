"""Tests of `runtime_plan`."""
