"""Many runs and what they tell: sweeps and the baselines."""
