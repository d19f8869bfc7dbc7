"""Pairs of a render material and a physical material that ship with Mana, for materials of scenes at reset time."""
