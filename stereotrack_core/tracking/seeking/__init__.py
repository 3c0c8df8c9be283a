"""Looking for the body: who is there, poses to begin from, and which way somebody faces."""
