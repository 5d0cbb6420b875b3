"""Words of documents and sources, first words of docstrings, subjects of commits: matches, and exceptions."""

import pytest

from infra.ci import wording


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Nobody reads it.\n\nIt is told apart.", [(1, "Nobody"), (3, "told")]),
        ("It is no camera, too.", [(1, "is no"), (1, "too")]),
        ("There is no camera. Too few views, too old.", []),
        ("```sh\nnobody\n```\n`nobody` [page](nobody.md) anew", [(4, "anew")]),
        (f"| {'a' * 200} | {'b' * 201} |", [(1, "cell of 201 characters")]),
    ],
)
def test_discouraged_words_and_long_cells_are_found_outside_code(
    text: str, expected: list[tuple[int, str]]
) -> None:
    assert list(wording.findings(text)) == expected


def test_document_may_have_a_few_findings() -> None:
    few = "anew\n" * wording.MAX_FINDINGS
    assert wording.document_problems("docs/a.md", few) == []
    (problem,) = wording.document_problems("docs/a.md", few + "anew")
    assert problem.startswith("docs/a.md: 4 discouraged")
    assert "docs/a.md:2: anew" in problem


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("let told = 0;", 1),
        ("/* by whoever, anew */", 2),
        ('t("capture.begun_anew")', 0),
    ],
)
def test_words_without_an_actor_are_found_in_sources(line: str, words: int) -> None:
    problems = wording.actor_problems("a.js", f"// the caller\n{line}\n")
    assert [problem.partition(" ")[0] for problem in problems] == ["a.js:2:"] * words


@pytest.mark.parametrize(
    ("subject", "problems"),
    [
        ("F" * 72, 0),
        ("F" * 73, 1),
        ("freeze the clock.", 2),
    ],
)
def test_subject_is_short_capitalised_and_without_full_stop(subject: str, problems: int) -> None:
    assert len(wording.subject_problems(subject)) == problems


@pytest.mark.parametrize(
    ("path", "text", "problems"),
    [
        ("a.py", '"""What it does."""\n\ndef f():\n    """Sum."""\n', 1),
        ("a.py", 'class A:\n    def f(self):\n        """Returns what fits."""\n', 1),
        ("a.py", 'def _f():\n    """How it works."""\n', 0),
        ("a.js", "// Where boards are.\n/** Which board. */\n/** Board. */", 2),
    ],
)
def test_docstrings_open_with_a_noun(path: str, text: str, problems: int) -> None:
    assert len(wording.opening_problems(path, text)) == problems


def test_unknown_base_has_no_commits_to_check() -> None:
    assert wording.git_lines("log", "--format=%s", "origin/no-such-branch..HEAD") == []
    assert len(wording.git_lines("log", "--format=%s", "-1")) == 1
