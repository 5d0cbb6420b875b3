"""Deployment of calibDB to an AWS account: `python -m infra.deploy`."""
