"""Free bodies with joints: tossed hinges, dropped scissors."""
