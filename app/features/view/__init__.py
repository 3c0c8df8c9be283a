"""How views and scene are shown."""
