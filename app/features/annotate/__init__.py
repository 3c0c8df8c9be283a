"""Annotate: landmarks by clicks, and everything that helps with them."""
