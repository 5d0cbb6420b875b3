"""Puts calibDB into an AWS account: `python -m infra.deploy`."""
