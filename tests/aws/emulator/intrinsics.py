"""CloudFormation's intrinsic functions, resolved to local values. An unknown one is an error."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

REGION = "us-east-1"
ACCOUNT = "123456789012"
_PSEUDO_PARAMETERS = {
    "AWS::AccountId": ACCOUNT,
    "AWS::Partition": "aws",
    "AWS::Region": REGION,
    "AWS::StackName": "calibdb",
    "AWS::URLSuffix": "amazonaws.com",
}
_ARNS = {
    "AWS::DynamoDB::Table": f"arn:aws:dynamodb:{REGION}:{ACCOUNT}:table/{{}}",
    "AWS::S3::Bucket": "arn:aws:s3:::{}",
    "AWS::SQS::Queue": f"arn:aws:sqs:{REGION}:{ACCOUNT}:{{}}",
    "AWS::Serverless::Function": f"arn:aws:lambda:{REGION}:{ACCOUNT}:function:{{}}",
}


def text(value: Any) -> str:
    """Convert a scalar to the string that CloudFormation makes of it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


@dataclass(frozen=True)
class Resolver:
    """Replaces intrinsic functions by their local values; raises ValueError for unknown ones."""

    parameters: Mapping[str, Any]
    resources: Mapping[str, Any]

    def __call__(self, value: Any) -> Any:
        """Return the value, resolved throughout."""
        match value:
            case {"Ref": str(name), **others} if not others:
                return self._ref(name)
            case {"Fn::GetAtt": [name, attribute]}:
                return self._attribute(name, attribute)
            case {"Fn::Sub": str(pattern)}:
                return re.sub(r"\$\{([^}]+)\}", self._substitute, pattern)
            case {**members}:
                if unknown := [key for key in members if key.startswith("Fn::") or key == "Condition"]:
                    raise ValueError(f"the local stack does not know {unknown[0]}")
                return {key: self(element) for key, element in members.items()}
            case [*elements]:
                return [self(element) for element in elements]
        return value

    def _ref(self, name: str) -> Any:
        known = {**_PSEUDO_PARAMETERS, **self.parameters}
        if name in known:
            return known[name]
        # A function's name is its logical id, so that a log line leads back to the template; bucket and table
        # names must be lower case and look like ones.
        if self.resources[name]["Type"] == "AWS::Serverless::Function":
            return name
        return f"calibdb-{name.lower()}"

    def _attribute(self, name: str, attribute: str) -> str:
        assert attribute == "Arn", f"the emulator does not know !GetAtt {name}.{attribute}"
        return _ARNS[self.resources[name]["Type"]].format(self._ref(name))

    def _substitute(self, match: re.Match[str]) -> str:
        resource, dot, attribute = match[1].partition(".")
        return self._attribute(resource, attribute) if dot else text(self._ref(resource))
