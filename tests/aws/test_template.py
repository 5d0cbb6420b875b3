"""The template is read as SAM and CloudFormation read it, and nothing is guessed."""

from pathlib import Path

import pytest

from infra.deploy.intrinsics import TemplateError
from tests.aws.emulator.template import RouteSpec, load

ROOT = Path(__file__).parents[2]
HEAD = """
Parameters:
  Level: {Type: Number, Default: 5}
  Secret: {Type: String, NoEcho: true}
Globals:
  Function:
    Handler: app.handler
    Timeout: 10
    Layers: [!Ref Base]
    Environment: {Variables: {TABLE: !Ref Index, LEVEL: !Ref Level, SECRET: !Ref Secret}}
Resources:
  Base: {Type: AWS::Serverless::LayerVersion, Properties: {ContentUri: layers/base/}}
  Index:
    Type: AWS::DynamoDB::Table
    Properties:
      AttributeDefinitions: [{AttributeName: id, AttributeType: S}]
      KeySchema: [{AttributeName: id, KeyType: HASH}]
"""


def read(tmp_path: Path, resources: str, **parameters: str) -> object:
    path = tmp_path / "template.yaml"
    path.write_text(HEAD + resources)
    return load(path, {"Secret": "s", **parameters})


def test_the_deployments_template_is_understood() -> None:
    template = load(ROOT / "template.yaml", {"SessionSecrets": "a" * 32, "ContributorSecret": "b" * 32})
    submit = template.functions["SubmitFunction"]
    assert submit.code == ROOT / "functions" / "submit"
    assert (submit.handler, submit.timeout, submit.memory) == ("app.handler", 29.0, 1769)
    assert template.functions["RefitFunction"].timeout == 60.0
    assert submit.environment["REFIT_FUNCTION"] == "RefitFunction"
    assert submit.environment["THRESHOLDS"] == ""
    assert "REFIT_FUNCTION" not in template.functions["AuthFunction"].environment
    assert RouteSpec("DELETE", "/v1/session/views/{index}", "SubmitFunction") in template.routes
    assert template.cors is not None
    assert template.cors.max_age == 86400
    assert [layer.name for layer in template.layers] == ["service", "solver"]


def test_globals_merge_as_sam_merges_them(tmp_path: Path) -> None:
    template = read(
        tmp_path,
        """
  One:
    Type: AWS::Serverless::Function
    Properties:
      CodeUri: one/
      Timeout: 3
      Layers: [!Ref Base]
      Environment: {Variables: {OWN: !Sub "${Index}-${AWS::Region}-${!kept}", LEVEL: 7}}
""",
    )
    one = template.functions["One"]  # type: ignore[attr-defined]
    assert one.timeout == 3.0
    assert one.environment == {
        "TABLE": "calibdb-index",
        "LEVEL": "7",
        "SECRET": "s",
        "OWN": "calibdb-index-us-east-1-${kept}",
    }


FUNCTION = """
  {name}:
    Type: AWS::Serverless::Function
    Properties: {{CodeUri: x/, Environment: {{Variables: {{{variables}}}}}}}
"""


def test_functions_share_one_environment_and_may_not_disagree(tmp_path: Path) -> None:
    agree = FUNCTION.format(name="One", variables="A: 1") + FUNCTION.format(name="Two", variables="B: 2")
    union = read(tmp_path, agree).environment()  # type: ignore[attr-defined]
    assert union == {"TABLE": "calibdb-index", "LEVEL": "5", "SECRET": "s", "A": "1", "B": "2"}
    differ = FUNCTION.format(name="One", variables="A: 1") + FUNCTION.format(name="Two", variables="A: 2")
    with pytest.raises(TemplateError, match="Two and One give A different values"):
        read(tmp_path, differ).environment()  # type: ignore[attr-defined]


def test_values_go_over_defaults_and_one_is_needed(tmp_path: Path) -> None:
    text = FUNCTION.format(name="One", variables="ARN: !GetAtt Index.Arn, FLAG: true")
    template = read(tmp_path, text, Level="9", Unknown="ignored")
    environment = template.functions["One"].environment  # type: ignore[attr-defined]
    assert environment["LEVEL"] == "9"
    assert environment["ARN"] == "arn:aws:dynamodb:us-east-1:123456789012:table/calibdb-index"
    assert environment["FLAG"] == "true"
    with pytest.raises(TemplateError, match="parameter Secret has neither"):
        load(tmp_path / "template.yaml", {})


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
def test_unsupported_resources_are_named(tmp_path: Path, value: str, complaint: str) -> None:
    with pytest.raises(TemplateError, match=complaint.replace("!", "\\!")):
        read(tmp_path, FUNCTION.format(name="One", variables=f"X: {value}"))
