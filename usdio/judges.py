"""Import this where many files will be judged: gate, validators and SimReady's rules are then loaded once."""

import usdio.gate  # noqa: F401
from usdio.outside import simready_rules

simready_rules()
