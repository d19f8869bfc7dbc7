"""Import this where many files will be judged: gate, validators and SimReady's rules are then loaded once."""

import gate.static_gate  # noqa: F401
from gate.external_validators import simready_rules

simready_rules()
