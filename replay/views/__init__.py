"""Camera views of an episode: how much of the task inserted objects hide."""
