"""Speed as ratios to well-known work on the same machine in the same run."""
