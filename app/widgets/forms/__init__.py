"""Fields, bars and pages."""
