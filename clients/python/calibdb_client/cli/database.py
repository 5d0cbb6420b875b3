"""The command `cameras`."""

from __future__ import annotations

from argparse import Namespace
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..errors import CalibDBError, UsageError
from ..key import CameraKey
from . import options
from .output import Output

if TYPE_CHECKING:
    from ..client import Client
    from ..devices import Device

_DEFAULT_SIZE = (1280, 720)


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands,
        "cameras",
        run,
        "list the cameras of this machine, or search the database",
        "List the cameras of this machine and whether the database knows them; or, with words, "
        "search the database.",
    )
    parser.add_argument("words", nargs="*", help="beginnings of words of names in the database")
    parser.add_argument(
        "--size", type=options.size, default=_DEFAULT_SIZE, metavar="WxH", help="size to look up"
    )
    options.add_service(parser)


def run(chosen: Namespace, output: Output) -> int:
    """List cameras."""
    return _search(chosen, output) if chosen.words else _list(chosen, output)


def _search(chosen: Namespace, output: Output) -> int:
    words = " ".join(chosen.words)
    with options.client(chosen) as client:
        cameras = client.cameras(words)
    if output.json:
        output.document({"cameras": cameras})
    else:
        output.facts([(str(each["key"]), f"{each['camera']}: {_sizes(each)}") for each in cameras])
        if not cameras:
            output.note(f"the database shows no camera called {words!r}")
    return 0 if cameras else 1


def _sizes(camera: Any) -> str:
    return ", ".join(
        f"{each['img_size'][0]}x{each['img_size'][1]}{'' if each['reliable'] else ' (not reliable)'}"
        for each in camera["sizes"]
    )


def _list(chosen: Namespace, output: Output) -> int:
    from ..devices import devices

    cameras = devices()
    states: dict[str, str] = {}
    try:
        client = options.client(chosen)
    except UsageError:
        output.note("set CALIBDB_URL and CALIBDB_TOKEN to see which of them the database knows")
    else:
        with client:
            states = _lookup_outcomes(client, cameras, chosen.size)
    if output.json:
        records = [
            {
                "index": each.index,
                "camera": each.label,
                "platform": each.platform,
                "path": each.path,
                "known": states.get(each.label),
            }
            for each in cameras
        ]
        output.document({"cameras": records})
        return 0 if cameras else 1
    equal = Counter(each.label for each in cameras)
    for each in cameras:
        twin = "one of several with this name: tell them apart by index" if equal[each.label] > 1 else ""
        parts = (each.label, each.path, states.get(each.label, ""), twin)
        output.facts([(str(each.index), "  ".join(filter(None, parts)))])
    if not cameras:
        output.note("there is no camera here, or none that this user may open")
    return 0 if cameras else 1


def _lookup_outcomes(client: Client, cameras: Sequence[Device], size: tuple[int, int]) -> dict[str, str]:
    """Return by label ``known``, or a lookup's reason."""
    outcomes: dict[str, str] = {}
    for each in cameras:
        if each.label in outcomes:
            continue
        try:
            answer = client.lookup(CameraKey(each.label, each.platform, size))
        except CalibDBError as error:
            if error.exit_status in (3, 4, 5):
                raise
            outcomes[each.label] = "not a camera that can be looked up"
        else:
            outcomes[each.label] = "known" if answer.calibration else answer.reason
    return outcomes
