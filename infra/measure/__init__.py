"""Measurements of a stack: its cost on AWS, and its behaviour under load."""
