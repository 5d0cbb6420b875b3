"""Measurements of a stack: its capacity, its processor, and its behaviour under load."""
