"""What every feature may use: actions, tasks, messages."""
