"""Terminal: tables, progress with the time left, announced steps, questions."""
