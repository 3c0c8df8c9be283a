"""Review: where and why a run fails."""
