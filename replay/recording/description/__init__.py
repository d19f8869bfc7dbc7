"""Recordings described by a file: `episode.json` and the URDF or MuJoCo models that it names, as an episode."""
