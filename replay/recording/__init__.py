"""Recorded episodes: reading of formats, kinematics, shapes of links, camera views."""
