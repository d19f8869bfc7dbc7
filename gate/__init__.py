"""Static gate: plausibility rules over released USD packages (`static_gate`), and external validators of them."""
