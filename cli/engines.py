"""What `mana` chooses and packages below `cli` only take by name (`sim.named_engine`): engines, and compositions."""

SIMULATOR = "sim.bullet.simulator:BulletSimulator"  # drops, settling and grasps of packages
REPLAY_ENGINE = "sim.bullet.replay_engine:BulletReplayEngine"  # roll-outs of measured bodies and linkages
REPLAY_CANDIDATES = "cli.replay.candidates:candidates"  # objects for recordings: plans, or packages as scenes see them
