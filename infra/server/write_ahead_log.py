"""SQLite's write-ahead log: commits that a damaged frame makes unreadable.

SQLite reads a log up to the first frame whose checksum is wrong, and silently ignores what follows. After a
crash that is right: the last write was not finished. If frames after it are sound, the log was damaged, and
they are commits that are lost.

Source: sqlite.org/fileformat2.html, section 4, "The Write-Ahead Log".
"""

import struct
from pathlib import Path

_HEADER_BYTES, _FRAME_HEADER_BYTES = 32, 24
_BIG_ENDIAN, _LITTLE_ENDIAN = 0x377F0683, 0x377F0682
_WORD = 0xFFFFFFFF


def lost_commits(path: Path) -> int:
    """Count the commits after the first damaged frame of the log; 0 if there is no log."""
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return 0
    if len(content) < _HEADER_BYTES + _FRAME_HEADER_BYTES:
        return 0
    magic, _, page_size, _, *salts = struct.unpack(">6I", content[:24])
    order = {_BIG_ENDIAN: ">", _LITTLE_ENDIAN: "<"}.get(magic)
    size = _FRAME_HEADER_BYTES + page_size
    frames = range(_HEADER_BYTES, len(content) - size + 1, size) if 512 <= page_size <= 65536 else range(0)
    first = struct.unpack(">2I", content[24:32])
    if order is None or not frames or _checksum(order, content[:24], (0, 0)) != first:
        # The header is written first and whole: without it everything in the log is lost.
        return sum(1 for start in frames if content[start + 4 : start + 8] != bytes(4)) or 1
    before, doubtful, lost = first, 0, 0
    damaged = False
    for start in frames:
        frame = content[start : start + size]
        _, pages, *own = struct.unpack(">4I", frame[:16])
        stored = struct.unpack(">2I", frame[16:24])
        sound = own == salts and _checksum(order, frame[:8] + frame[24:], before) == stored
        damaged = damaged or not sound
        doubtful += damaged and pages != 0
        if damaged and sound:  # so the frames before it were written, too
            lost = doubtful or 1
        before = stored
    return lost


def _checksum(order: str, content: bytes, start: tuple[int, ...]) -> tuple[int, int]:
    first, second = start
    words = struct.unpack(f"{order}{len(content) // 4}I", content)
    for one, other in zip(words[::2], words[1::2], strict=True):
        first = (first + one + second) & _WORD
        second = (second + other + first) & _WORD
    return first, second
