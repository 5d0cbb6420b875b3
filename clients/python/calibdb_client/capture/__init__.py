"""Guided capture: a camera's frames, the target, when a view is taken, and the feedback to the user."""
