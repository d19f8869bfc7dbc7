"""Acceptance of the joints of one released package: their exercise in simulation, and the twins beside the USD.

Read `judge_joints` first.
"""
