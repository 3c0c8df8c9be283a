"""A study: many recordings with their projects and conditions, tracked and evaluated together."""
