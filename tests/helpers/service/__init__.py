"""Helpers of the service's tests: a client, stored documents, IAM."""
