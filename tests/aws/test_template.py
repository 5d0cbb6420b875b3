"""The emulator guesses nothing: an intrinsic function that it does not know is an error."""

from pathlib import Path

import pytest

from tests.aws.emulator.intrinsics import TemplateError
from tests.aws.emulator.template import load

TEMPLATE = """
Resources:
  Index: {{Type: AWS::DynamoDB::Table}}
  One:
    Type: AWS::Serverless::Function
    Properties: {{CodeUri: x/, Handler: app.handler, Environment: {{Variables: {{X: {value}}}}}}}
"""


@pytest.mark.parametrize(
    ("value", "complaint"),
    [
        ("!Ref Nobody", "!Ref Nobody names nothing"),
        ("!ImportValue Other", "does not know Fn::ImportValue"),
        ("!GetAtt Index.StreamArn", "does not know !GetAtt Index.StreamArn"),
        ("!If [IsProd, a, b]", "does not know Fn::If"),
        ("[1, 2]", "stands where a string is wanted"),
        ("{a: 1}", "stands where a string is wanted"),
    ],
)
def test_unsupported_value_is_named(tmp_path: Path, value: str, complaint: str) -> None:
    path = tmp_path / "template.yaml"
    path.write_text(TEMPLATE.format(value=value))
    with pytest.raises(TemplateError, match=complaint):
        load(path, {})
