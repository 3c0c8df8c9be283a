"""Themes, icons and colours."""
