"""Runs against each other: by how much, and whether so many frames can show it."""
