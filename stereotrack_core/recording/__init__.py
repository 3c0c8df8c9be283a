"""A recording folder: what it says about itself, and frame k of view v."""
