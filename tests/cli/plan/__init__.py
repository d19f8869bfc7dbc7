"""Tests of `cli.plan.app`."""
