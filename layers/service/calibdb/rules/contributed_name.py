"""Names of a camera and of its modes by most of their contributors."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence

from calibdb.camera_key.label import public_mode_name
from calibdb.schema import CalibrationDocument


def most_contributed(
    group: Sequence[CalibrationDocument], public: Callable[[CalibrationDocument], str]
) -> str:
    """Text, such as a public label, of most contributors; of equals the oldest."""
    contributors: dict[str, set[str]] = {}
    for document in sorted(group, key=lambda d: (d.time, d.id)):
        contributors.setdefault(public(document), set()).add(document.counted_as)
    return max(contributors, key=lambda text: len(contributors[text]))  # the first of equals


def mode_names(groups: Sequence[Iterable[tuple[str, str]]]) -> tuple[str | None, ...]:
    """Name of each group by most of its contributors; None if another group has the same.

    `groups`: contributors and their names.
    """
    names = [_mode_name(group) for group in groups]
    counts = Counter(name.casefold() for name in names if name)
    return tuple(name if name and counts[name.casefold()] == 1 else None for name in names)


def _mode_name(group: Iterable[tuple[str, str]]) -> str | None:
    contributors: dict[str, set[str]] = defaultdict(set)
    spellings: dict[str, str] = {}
    for contributor, text in group:
        if name := public_mode_name(text):
            contributors[name.casefold()].add(contributor)
            spellings[name.casefold()] = min(spellings.get(name.casefold(), name), name)
    if not contributors:
        return None
    return spellings[max(sorted(contributors), key=lambda name: len(contributors[name]))]
