"""What a stretch would look like with other parameters: clouds that are kept, and trials."""
