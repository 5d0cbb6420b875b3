"""Audit of dependencies: a vulnerability fails it, an index that does not answer is reported."""

from pathlib import Path

import pytest

from infra.ci import audit
from infra.ci.audit import Audit, of_npm, of_pip, pins, report

ROOT = Path(__file__).parents[3]
# As pip-audit 2.10 and npm 10 write it.
PIP = {
    "dependencies": [
        {"name": "fine", "version": "1.0", "vulns": []},
        {"name": "old", "version": "0.1", "vulns": [{"id": "PYSEC-2024-1", "fix_versions": ["0.2"]}]},
        {"name": "unknown", "skip_reason": "Dependency not found on PyPI and could not be audited"},
    ]
}
NPM = {
    "vulnerabilities": {
        "bad": {"name": "bad", "severity": "critical"},
        "meh": {"name": "meh", "severity": "low"},
    },
    "metadata": {"dependencies": {"total": 90}},
}
REFUSED = {"message": "405 Method Not Allowed", "error": {"summary": "", "detail": ""}}


def test_findings_of_the_tools_are_reported() -> None:
    assert of_pip(PIP) == Audit(2, ("old 0.1: PYSEC-2024-1",))
    assert of_npm(NPM) == Audit(90, ("bad: critical",))
    assert report("npm", of_npm(NPM)).splitlines()[1:] == ["bad: critical"]


def test_unanswered_audit_is_reported_as_not_audited() -> None:
    nobody = of_pip({"dependencies": PIP["dependencies"][2:]})
    assert nobody == of_npm(REFUSED) == Audit(0)
    assert "not audited" in report("npm", nobody)


@pytest.mark.parametrize(("found", "status"), [(Audit(0), 0), (Audit(90), 0), (Audit(90, ("bad: high",)), 1)])
def test_only_vulnerable_packages_fail(found: Audit, status: int) -> None:
    packages = pins(*(ROOT / lock for lock in audit.LOCKS))
    assert {pin.partition("==")[0] for pin in packages} >= {"botocore", "numpy", "pytest"}
    silent = "http://127.0.0.1:9/"
    assert audit.main({"Python": lambda: audit.python(packages, silent), "npm": lambda: found}) == status
