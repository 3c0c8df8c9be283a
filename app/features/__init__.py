"""What a person does with the workbench, a room for each kind of work."""
