"""Clicks in the views."""
