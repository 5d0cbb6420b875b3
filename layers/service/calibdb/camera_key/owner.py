"""Owners' names and other personal data in labels."""

import re

from calibdb.camera_key.apple import CAMERA_WORDS
from calibdb.camera_key.names import is_generic

_ADDRESS = re.compile(
    r"\S*@\S*"
    r"|(?<![\w.])[0-9]{1,3}(?:\.[0-9]{1,3}){3}(?::[0-9]+)?(?![\w.])"
    r"|(?<![\w:])(?:[0-9a-f]{0,4}[:]){2,}[0-9a-f:.]*(?![\w:])",
    re.IGNORECASE,
)
_FOLDERS = re.compile(
    r"(?<![\w.])[a-z]:[\\/](?:[^\\/]*[\\/])*|\\\\(?:[^\\]*\\)+|(?<!\S)(?:file://)?[~.]{0,2}/(?:[^/\s]*/)+",
    re.IGNORECASE,
)
_URL = re.compile(r"\b[a-z][a-z0-9+.-]{1,15}://\S*|\bwww\.\S+", re.IGNORECASE)
# With the country's number, with the 0 of long distance, or in America's groups. Other digits may distinguish
# two cameras, and stay.
_BETWEEN = r"[\s().,/\u2010-\u2015-]{0,3}"
_TELEPHONE = re.compile(
    rf"(?<!\w)(?<!\w-)(?<!\d\.)(?:[+＋][\s(]?\d(?:{_BETWEEN}\d){{6,14}}|\(?[0０]\d(?:{_BETWEEN}\d){{6,13}}"
    r"|\(?\d{3}\)?[ .-]\d{3}[ .-]\d{4})(?!\w)"
)
_HOST_NAME = re.compile(
    r"(?<![\w-])(?!usb)[\w-]+-(?:pc|laptop|notebook|desktop|macbook)(?![\w-])"
    r"|(?<![\w-])(?:desktop|laptop)-[0-9a-z]{5,}(?![\w-])",
    re.IGNORECASE,
)
_QUOTED = re.compile(r"[„“«][^„“”«»]*[“”»]|[„“”«»]")
_PARENTHESES = re.compile(r"\(([^()]*)\)|\([^()]*$|[()]")
# Models in parentheses: `(2)`, `(V-U0028)`.
_MODEL = re.compile(r"(?=.*[0-9])[A-Z]{0,5}[-.]?[A-Z]{0,3}[0-9][0-9A-Za-z.+-]{0,12}")
_WORD = re.compile(r"[^\s/_-]+")
_POSSESSIVE = re.compile(r"^.*['’‘ʼ´`]s?(?: +|$)", re.IGNORECASE)
_PRODUCTS = (
    r"galaxy|pixel|redmi|xperia|oneplus|nothing phone|moto|huawei|honor|oppo|vivo|realme|poco|nokia|xiaomi|"
    r"fairphone|zenfone|iphone|ipad|macbook|imac|thinkpad|ideapad|handy"
)
_GENITIVE = re.compile(rf"^(?:[\w.-]+ +){{0,3}}\w{{2,40}}s +(?=(?:{_PRODUCTS})\b)", re.IGNORECASE)
# "Field of view" describes cameras; AV, AF and VAN are not prepositions.
_TAIL = re.compile(r"^(.*?)(?:^| +)(?:of(?! +[Vv]iew)|von|vom|van|av|af|fra|od|від|от|del|della)(?: .*)?$")
_SHORT_TAIL = re.compile(
    rf"^(.*\b(?:{_PRODUCTS}|tablet|phone|webcam|{'|'.join(CAMERA_WORDS)})\b.*?) +(?:de|di|da|do) +(.*)$",
    re.IGNORECASE,
)


def without_path(name: str) -> str:
    """Camera's name without folders, which may contain a user's name, and without URLs."""
    return " ".join(_URL.sub(" ", _FOLDERS.sub(" ", name)).split())


def without_telephone(name: str) -> str:
    """Camera's name without telephone numbers."""
    return " ".join(_TELEPHONE.sub(" ", name).split())


def without_owner(name: str) -> str:
    """Camera's name without names of persons and computers, and addresses."""
    # Until nothing is left to cut: one rule may expose what another cuts.
    while (shorter := _cut(name)) != name:
        name = shorter
    return name


def _cut(name: str) -> str:
    for pattern in (_ADDRESS, _HOST_NAME, _QUOTED):
        name = pattern.sub(" ", name)
    name = _PARENTHESES.sub(_keep_parentheses, name)
    name = _GENITIVE.sub("", _POSSESSIVE.sub("", name))
    if match := _TAIL.match(name):
        name = match[1]
    match = _SHORT_TAIL.match(name)
    if match and match[2][:1].isupper():
        name = match[1]
    return " ".join(name.split())


def _keep_parentheses(match: re.Match[str]) -> str:
    words = _WORD.findall(match[1] or "")
    if words and all(_MODEL.fullmatch(word) or is_generic(word.casefold()) for word in words):
        return match[0]
    return " "
