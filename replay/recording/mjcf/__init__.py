"""MuJoCo MJCF models of recorded episodes: `read` parses a file, `episode_parts` makes robots, objects and fixtures."""
