"""Conditions that a node of a task may state: one file each, and one row each in `table`.

A condition is a pydantic model of its parameters. Start with `protocol`; docs/contributing/predicate.md has
a worked example.
"""
