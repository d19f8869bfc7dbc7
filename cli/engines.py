"""The engines that `mana` chooses, each by name (`sim.named_engine`). No package below `cli` names one."""

SIMULATOR = "sim.bullet.simulator:BulletSimulator"  # drops, settling and grasps of packages
REPLAY_ENGINE = "sim.bullet.replay_engine:BulletReplayEngine"  # roll-outs of measured bodies and linkages
