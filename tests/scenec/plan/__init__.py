"""Tests of `scenec.plan.document`."""
