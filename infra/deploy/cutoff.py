"""Function that disables the distribution, which then answers nothing and costs nothing.

The template contains this file as inline code, at most 4,096 characters.
"""

import os
from typing import Any

import boto3


def switch(cloudfront: Any, distribution: str, *, enabled: bool) -> bool:
    """Enable or disable the distribution, which takes minutes; False if it is so already."""
    current = cloudfront.get_distribution_config(Id=distribution)
    config = current["DistributionConfig"]
    if config["Enabled"] == enabled:
        return False
    cloudfront.update_distribution(
        Id=distribution, IfMatch=current["ETag"], DistributionConfig={**config, "Enabled": enabled}
    )
    return True


def handler(_event: object, _context: object) -> None:
    """Disable the distribution."""
    switch(boto3.client("cloudfront"), os.environ["DISTRIBUTION"], enabled=False)
