"""A small deployment of its own for tests: a template, functions from source text, a folder of pages."""

from collections.abc import Mapping
from pathlib import Path
from textwrap import dedent, indent

TEMPLATE = """
AWSTemplateFormatVersion: "2010-09-09"
Transform: AWS::Serverless-2016-10-31
Globals:
  Function:
    Runtime: python3.13
    Handler: app.handler
    Timeout: 10
    Environment:
      Variables:
        BUCKET: !Ref Files
Resources:
  Api:
    Type: AWS::Serverless::HttpApi
    Properties:
      CorsConfiguration:
        AllowOrigins: ["https://page.example", "https://other.example"]
        AllowMethods: [GET, POST]
        AllowHeaders: [authorization, content-type]
        ExposeHeaders: [location]
        MaxAge: 600
  Files:
    Type: AWS::S3::Bucket
"""

FUNCTION = """
{name}:
  Type: AWS::Serverless::Function
  Properties:
    CodeUri: functions/{name}/
    Events:
"""

EVENT = "      E{number}: {{Type: HttpApi, Properties: {{Method: {method}, Path: '{path}'}}}}\n"


def deploy(place: Path, functions: Mapping[str, tuple[str, tuple[str, ...]]]) -> Path:
    """Write a template with functions under `place`, return its path.

    `functions`: name -> (source of app.py, routes such as "GET /v1/x").
    """
    text = TEMPLATE
    for name, (source, routes) in functions.items():
        code = place / "functions" / name
        code.mkdir(parents=True, exist_ok=True)
        (code / "app.py").write_text(dedent(source))
        block = (
            FUNCTION.format(name=name) if routes else FUNCTION.format(name=name).replace("    Events:\n", "")
        )
        for number, route in enumerate(routes):
            method, path = route.split()
            block += EVENT.format(number=number, method=method, path=path)
        text += indent(block, "  ")
    template = place / "template.yaml"
    template.write_text(text)
    return template
