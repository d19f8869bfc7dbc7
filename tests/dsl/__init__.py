"""Tests of task and pipeline files."""
