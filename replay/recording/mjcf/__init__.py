"""MuJoCo MJCF models of recorded episodes: bodies, meshes, cameras."""
