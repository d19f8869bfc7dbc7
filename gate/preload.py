"""Preloads the gate, the validators and SimReady's rules on import, once for a batch of validated files."""

import gate.static_gate  # noqa: F401
from gate.external_validators import simready_rules

simready_rules()
