"""Helpers of the solver's tests: synthetic cameras, users, exports."""
