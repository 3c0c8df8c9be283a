"""Many runs over recordings, seeds and values of parameters, and what they come to."""
