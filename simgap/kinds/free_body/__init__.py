"""Free bodies: tossed, dropped, sliding, rolling things."""
