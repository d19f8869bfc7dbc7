"""Engines that fail when they roll out a mechanism: with an error, with a crash of the process, by never ending."""

from __future__ import annotations

import os
import time
from typing import NoReturn

from sim.bullet.replay_engine import BulletReplayEngine


class RefusingEngine(BulletReplayEngine):
    def mechanism_rollout_at(self, step_s: float) -> NoReturn:
        raise ValueError("no joints of this kind")


class CrashingEngine(BulletReplayEngine):
    def mechanism_rollout_at(self, step_s: float) -> NoReturn:
        os.abort()


class EndlessEngine(BulletReplayEngine):
    def mechanism_rollout_at(self, step_s: float) -> NoReturn:
        while True:
            time.sleep(1.0)
