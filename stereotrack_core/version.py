"""Which version of this program this is."""

__version__ = "0.1.0"
