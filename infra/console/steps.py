"""Steps of a long piece of work, each announced with the time that is left.

What steps print themselves (compilers, the SAM CLI) would tear a bar apart; a line before each step survives
it. The time left is that of the previous run of the same steps, kept in `.build/durations.json`.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

ROOT = Path(__file__).resolve().parents[2]
DURATIONS = ROOT / ".build" / "durations.json"

Step = TypeVar("Step")


def _say(text: str) -> None:
    # Before what a step prints itself.
    print(text, flush=True)


def announce(
    work: str,
    steps: Sequence[Step],
    text: Callable[[Step], str],
    *,
    say: Callable[[str], None] = _say,
    clock: Callable[[], float] = time.monotonic,
    path: Path = DURATIONS,
) -> Iterator[Step]:
    """Yield the steps, each after a line with its number, its text, and the time left.

    Parameters
    ----------
    work
        Name under which the durations are kept.
    steps, text
        The steps, and what is said of each.
    say, clock, path
        Output, seconds, and the file of the durations; for tests.
    """
    previous = _read(path).get(work, {})
    texts = [text(step) for step in steps]
    for number, step in enumerate(steps):
        expected = [previous.get(each) for each in texts[number:]]
        say(f"{number + 1}/{len(texts)} {texts[number]}{_describe_time_left(expected)}")
        begun = clock()
        yield step
        previous[texts[number]] = round(clock() - begun, 1)
        _write(path, work, {each: previous[each] for each in texts if each in previous})


def format_duration(seconds: float) -> str:
    """Format a duration for people: `40 s`, `3 min`, `1 h 5 min`."""
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def _describe_time_left(expected: Sequence[float | None]) -> str:
    """Describe the time left, of which a step that never ran makes a lower bound."""
    durations = [seconds for seconds in expected if seconds is not None]
    if not durations:
        return ""
    return (
        f" ({'' if len(durations) == len(expected) else 'more than '}{format_duration(sum(durations))} left)"
    )


def _read(path: Path) -> dict[str, dict[str, float]]:
    """Read the durations; what is absent or damaged is left out."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return {
        work: {text: seconds for text, seconds in steps.items() if isinstance(seconds, int | float)}
        for work, steps in (record.items() if isinstance(record, dict) else ())
        if isinstance(steps, dict)
    }


def _write(path: Path, work: str, durations: dict[str, float]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({**_read(path), work: durations}, indent=1), encoding="utf-8")
