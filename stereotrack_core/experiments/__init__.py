"""Many runs and what they tell: benchmark, sweep, and the tables of the thesis."""
