"""Multibody dynamics in numpy: kinematic trees, joints with friction, mechanism roll-outs, and hooks for effects.

`body_rollout` and `linkage_rollout` are protocols for engines; `tree` holds the equations of motion.
"""
