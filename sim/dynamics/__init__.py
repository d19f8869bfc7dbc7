"""Rigid-body dynamics in numpy: kinematic trees, joints, mechanisms, free bodies and linkages, with hooks for
effects.
"""
