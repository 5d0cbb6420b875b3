"""Guided capture: a camera's frames, the target, when a view is taken, and what the person is told."""
