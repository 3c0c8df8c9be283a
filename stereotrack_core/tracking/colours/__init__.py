"""Colours of the parts, and their use where a datum looks for its part."""
