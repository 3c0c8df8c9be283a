"""Tests; a package of its own, because sleap-io installs one of the same name."""
