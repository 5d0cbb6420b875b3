"""CloudFormation's intrinsic functions, resolved to local values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

REGION = "us-east-1"
ACCOUNT = "123456789012"

_ARNS = {
    "AWS::DynamoDB::Table": f"arn:aws:dynamodb:{REGION}:{ACCOUNT}:table/{{}}",
    "AWS::S3::Bucket": "arn:aws:s3:::{}",
    "AWS::SQS::Queue": f"arn:aws:sqs:{REGION}:{ACCOUNT}:{{}}",
    "AWS::Serverless::Function": f"arn:aws:lambda:{REGION}:{ACCOUNT}:function:{{}}",
}


class TemplateError(ValueError):
    """The template says something that cannot be run locally."""


def text(value: Any) -> str:
    """Convert a scalar to the string that CloudFormation makes of it; raises TemplateError for others."""
    if not isinstance(value, bool | int | float | str):
        raise TemplateError(f"{value!r} stands where a string is wanted")
    return str(value).lower() if isinstance(value, bool) else str(value)


@dataclass(frozen=True)
class Resolver:
    """Replaces intrinsic functions by their local values."""

    parameters: Mapping[str, Any]
    resources: Mapping[str, Any]
    pseudo: Mapping[str, str] = field(
        default_factory=lambda: {
            "AWS::AccountId": ACCOUNT,
            "AWS::Partition": "aws",
            "AWS::Region": REGION,
            "AWS::StackName": "calibdb",
            "AWS::URLSuffix": "amazonaws.com",
        }
    )

    def __call__(self, value: Any) -> Any:
        """Return the value, resolved throughout; raises TemplateError if something in it is not known."""
        if isinstance(value, list):
            return [self(element) for element in value]
        if not isinstance(value, Mapping):
            return value
        if len(value) == 1:
            ((key, argument),) = value.items()
            if key == "Ref":
                return self._ref(argument)
            if key == "Fn::GetAtt":
                return self._attribute(*argument)
            if key == "Fn::Sub":
                return self._substitute(argument)
            if key == "Fn::Join":
                return argument[0].join(text(self(part)) for part in argument[1])
            if key.startswith("Fn::") or key == "Condition":
                raise TemplateError(f"the local stack does not know {key}")
        return {key: self(element) for key, element in value.items()}

    def _ref(self, name: str) -> Any:
        for values in (self.parameters, self.pseudo):
            if name in values:
                return values[name]
        if name not in self.resources:
            raise TemplateError(f"!Ref {name} names nothing in the template")
        # A function's name is its logical id, so that a log line leads back to the template; bucket and table
        # names must be lower case and look like ones.
        if self.resources[name]["Type"] == "AWS::Serverless::Function":
            return name
        return f"calibdb-{name.lower()}"

    def _attribute(self, name: str, attribute: str) -> str:
        if attribute != "Arn" or name not in self.resources:
            raise TemplateError(f"the local stack does not know !GetAtt {name}.{attribute}")
        kind = self.resources[name]["Type"]
        if kind not in _ARNS:
            raise TemplateError(f"the local stack does not know the Arn of a {kind}")
        return _ARNS[kind].format(self._ref(name))

    def _substitute(self, argument: Any) -> str:
        pattern, local = (argument, {}) if isinstance(argument, str) else argument

        def replace(match: re.Match[str]) -> str:
            name = match[1]
            if name.startswith("!"):
                return f"${{{name[1:]}}}"
            if name in local:
                return text(self(local[name]))
            resource, dot, attribute = name.partition(".")
            return self._attribute(resource, attribute) if dot else text(self._ref(name))

        return re.sub(r"\$\{([^}]+)\}", replace, pattern)
