"""Acceptance of one released package: validators, checks of the body, settling trials, stable poses, targeted repair.

Read `judge_package` first.
"""
