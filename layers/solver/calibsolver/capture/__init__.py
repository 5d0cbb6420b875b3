"""Guided capture: acceptance rules of one session's views."""
