"""Study: many recordings with their conditions in one table."""
