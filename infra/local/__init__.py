"""The same stack as on AWS, in one process."""

from infra.local.events import Response
from infra.local.stack import DEVELOPMENT_TOKEN, LocalStack

__all__ = ["DEVELOPMENT_TOKEN", "LocalStack", "Response"]
