"""Raw assets in, accepted simulation packages out, in seven explicit stages."""
