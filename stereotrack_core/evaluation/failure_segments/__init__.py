"""Failures: stretches in which a run fails, why it probably does, and pictures of them."""
