"""The `mana` command: the only place that prints, draws progress and chooses the simulator."""
