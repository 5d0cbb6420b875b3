"""Names that identify a product, and generic names."""

import re

_GENERIC_WORDS = """
    a the my of and with for
    camera camera2 cam cams webcam webcams web video usb uvc wdm pc device devices capture digital
    image imaging module integrated integrierte built in internal external laptop notebook computer
    desktop monitor display front rear back facing user world environment facetime
    hd fhd uhd qhd full ultra high definition vga svga qvga wide angle vision ir rgb infrared color colour
    depth stream streaming live af autofocus auto focus microphone mic dual triple telephoto tele truedepth
    general generic default standard plug play new multimedia universal
    pro plus mini lite max select essential business office home gaming
    iphone ipad ipod mm unnamed unknown none no name null
"""
# A maker is not a product: "HP Webcam" names a hundred of them.
_MAKERS = """
    acer apple asus azurewave bison chicony creative dell genius google hp hewlett packard huawei intel
    lenovo lg liteon logi logitech microsoft msi nvidia philips quanta realtek ricoh samsung sonix sony
    sunplus sunplusit suyin syntek toshiba trust vimicro xiaomi
"""
_MAKER = frozenset(_MAKERS.split())
_GENERIC = frozenset(_GENERIC_WORDS.split()) | _MAKER
# Names of built-in cameras of many modules: `Lenovo EasyCamera` has four USB ids.
_FAMILIES = re.compile(
    r"\b(?:facetime|easycamera|truevision|crystal eye|macbook(?: pro| air)?|imac|bisoncam|surface|"
    r"desk view|wide vision|hp (?:ir )?cam)\b"
)
# What an iPhone writes into its photographs: the model, which no browser reports.
_OWN_NAME = re.compile(r"\biphone (?:[0-9]{1,2}|x|se)\b|\bipad (?:[a-z]+ )?[0-9]{1,2}\b")
_MAX_WORD_LENGTH = 64  # they become parts of items' keys
_NAME_WORD = re.compile(r"[^\W_]+(?:\.[0-9]+)?")
# 2, 2.0, 720p, 4k, 5mp, usb2.0: counts, versions and sizes.
_MEASURE = re.compile(r"(?:usb)?[0-9]+(?:\.[0-9]+)?(?:p|k|mp|m|fps|x[0-9]+)?|0x[0-9a-f]+")
_STRIPPED = re.compile(r"^(?:logitech|logi|microsoft)\b[ ,.:-]*")


def words(name: str) -> list[str]:
    """Words of a name (lower case): letters and digits of any script."""
    return [word[:_MAX_WORD_LENGTH] for word in _NAME_WORD.findall(name)]


def is_generic(word: str) -> bool:
    """True if `word` (lower case) describes many cameras, or is a maker's name."""
    return word in _GENERIC or word in ("r", "c", "tm")


def is_maker(word: str) -> bool:
    """True if `word` (lower case) is the name of a maker."""
    return word in _MAKER


def says_too_little(name: str) -> bool:
    """True if many products have this name (lower case)."""
    if _FAMILIES.search(name):
        return True
    return all(len(word) < 2 or word in _GENERIC or _MEASURE.fullmatch(word) for word in words(name))


def names_its_model(name: str) -> bool:
    """True if `name` (lower case), written by an Apple device itself, identifies the model."""
    return _OWN_NAME.search(name) is not None


def without_maker(name: str) -> str:
    """Return `name` (lower case) without a maker that only some systems put before it.

    Only if the rest is not generic, as it is of `Logitech HD Webcam`.
    """
    rest = _STRIPPED.sub("", name)
    return name if says_too_little(rest) else rest
