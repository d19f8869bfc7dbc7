"""Effects of actuators on the commanded effort: gain, bias, delay, lag, saturation, deadband, ripple, supply sag."""
