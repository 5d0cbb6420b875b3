"""Programs that pose as cameras."""

import re

# The pages' simulated camera: its label names the lens, so it is as good as a real one.
_OURS = "calibdb virtual camera"

_NAMED = (
    *("camtwist", "manycam", "droidcam", "splitcam", "youcam", "sparkocam", "altercam", "chromacam"),
    *("webcamoid", "spoutcam", "snap camera", "unity video capture", "screen-capture-recorder"),
)
_PROGRAMS = {
    **{name: rf"\b{name}\b" for name in _NAMED},
    "obs virtual camera": r"\bobs(?:[ -]?virtual)?[ -]?cam(?:era)?\b|\bobs-?camera ?[0-9]*\b|^obs\b",
    "iriun webcam": r"\biriun\b",
    "epoccam": r"\bepoccam\b",
    "ivcam": r"\bivcam\b|\be2esoft\b",
    "camo": r"^camo\b|\breincubate camo\b|\bcamo(?: camera)?$",
    "nvidia broadcast": r"\bnvidia (?:broadcast|camera)\b",
    "xsplit vcam": r"\bxsplit\b",
    "mmhmm": r"\bmmhmm\b",
    "ecamm live": r"\becamm\b",
    "logi capture": r"\blogi(?:tech)? (?:capture|tune virtual)\b",
    "ndi video": r"\bnewtek ndi\b|\bndi (?:video|webcam|virtual)\b",
    "prism live": r"\bprism (?:live|lens)\b",
    "windows virtual camera": r"\(windows virtual camera\)|\bwindows virtual camera\b",
    "v4l2loopback": r"\bv4l2[ -]?loopback\b|\bdummy video device\b",
    # Chromium's and Firefox's, under test.
    "fake device": r"\bfake_device_[0-9]+\b|\bfake (?:device|camera)\b",
    "virtual camera": r"\bvirtual[ -]?(?:cam|camera|webcam)\b|\bvcam\b",
}
_PATTERNS = tuple((name, re.compile(pattern)) for name, pattern in _PROGRAMS.items())


def is_practice(name: str) -> bool:
    """True if a normalised name is that of the pages' simulated camera."""
    return name.startswith(_OURS)


def spelling_of(posing: str, label: str) -> str:
    """Program's name as `label` spells it."""
    match = re.search(_PROGRAMS[posing], label, re.IGNORECASE)
    return match[0].strip("()") if match else posing


def program(text: str) -> str | None:
    """Program behind a label (lower case), None if it is a camera."""
    if text.startswith(_OURS):
        return None
    return next((name for name, pattern in _PATTERNS if pattern.search(text)), None)
