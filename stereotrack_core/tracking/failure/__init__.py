"""Which limbs of a pose are probably wrong, told without truth."""
