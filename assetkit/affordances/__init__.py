"""Anchors, regions and grasps of one object: proposed from its shape, tried in the simulator. Read `find` first."""
