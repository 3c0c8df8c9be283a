"""Makes runs: side by side on the same clouds, by processes of this machine or by a cluster."""
