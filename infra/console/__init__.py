"""What a person at a terminal sees: tables, progress with the time left, questions, plots."""
