"""Intermediate representation of a scene: the placement problem (`problem`), its names, relaxed problems and the cache
of derived values. It imports no other phase.
"""
