"""Kind of device behind a label."""

import re
from dataclasses import dataclass

from calibdb.camera_key import Identity
from calibdb.camera_key.names import words
from calibdb.camera_key.system import System

_DEPTH = frozenset({"realsense", "zed", "kinect", "xtion", "orbbec", "oak", "depthai", "luxonis", "nui"})
_ACTION = frozenset(
    {"gopro", "hero", "osmo", "insta360", "runcam", "caddx", "foxeer", "akaso", "sjcam", "eken", "firefly"}
)
_DRONES = frozenset({"mavic", "phantom", "inspire", "skydio", "anafi", "dji"})
_BUILT_IN = frozenset({
    "integrated", "integrierte", "intégrée", "integrata", "integrada", "built", "internal", "laptop",
    "notebook", "facetime", "macbook", "imac", "truevision", "easycamera", "bisoncam", "surface",
    "crystal", "isight",
})  # fmt: skip
_PHONES = re.compile(r"\b(?:iphone|ipod|pixel|galaxy|redmi|poco|oneplus|xperia|huawei|sm-[a-z0-9]+)\b")
_TABLETS = re.compile(r"\b(?:ipad|tab|tablet)\b")
_HEADSETS = frozenset({"quest", "hololens"})
_MODULE = re.compile(r"\b(?:mmal|unicam|arducam|imx[0-9]{3}|ov[0-9]{4})\b")
# Vendors that make the cameras in lids: Chicony, AzureWave, Quanta, Bison, Sunplus, Realtek, Luxvisions,
# Syntek, Suyin, Apple, Foxlink, Shinetech, Cheng Uei
_LID_VENDORS = frozenset(
    {"04f2", "13d3", "0408", "5986", "1bcf", "0bda", "30c9", "174f", "064e", "05ac", "05c8", "3277", "0bf8"}
)
_VENDORS = {
    "046d": "Logitech", "045e": "Microsoft", "041e": "Creative", "8086": "Intel", "2b03": "Stereolabs",
    "03e7": "Luxonis", "413c": "Dell", "03f0": "HP", "05ac": "Apple", "2bc5": "Orbbec",
}  # fmt: skip
_PHONE_MAKERS = (
    ("Samsung", re.compile(r"^sm-|\bgalaxy\b|\bsamsung\b")),
    ("Google", re.compile(r"\bpixel\b|\bnexus\b")),
    ("Xiaomi", re.compile(r"\bredmi\b|\bpoco\b|^mi \b|\bxiaomi\b|^2[0-9]{3,}[a-z0-9]+$")),
    ("OnePlus", re.compile(r"\boneplus\b")),
    ("Motorola", re.compile(r"\bmoto\b|\bmotorola\b")),
    ("Apple", re.compile(r"\biphone|\bipad|\bipod|\bfacetime\b|\bmacbook\b|\bimac\b")),
)
_FRONT = frozenset({"front", "user", "truedepth", "selfie"})


@dataclass(frozen=True)
class Device:
    """Device by its label and platform; empty texts are unknown."""

    kind: str  # a key of `crops.SLOPES`; `webcam`: built in or not
    maker: str = ""
    camera: str = ""  # of a phone or tablet: `wide`, `ultrawide`, `tele`, `front`
    model_ids: frozenset[str] = frozenset()  # of a phone, lower case
    label_words: frozenset[str] = frozenset()  # with those of the phone's model
    usb_id: str | None = None


def device_of(identity: Identity, system: System) -> Device:
    """Classify the device behind a label on a system."""
    phone = system.model.casefold()
    label_words = frozenset(words(identity.name)) | frozenset(words(phone))
    text = f"{identity.name} {phone}"
    kind, camera = _kind_and_camera(identity, system, text, label_words)
    return Device(
        kind, _maker(identity, text, phone), camera, frozenset({phone} - {""}), label_words, identity.usb_id
    )


def _kind_and_camera(
    identity: Identity, system: System, text: str, label_words: frozenset[str]
) -> tuple[str, str]:
    if identity.virtual:
        return "virtual", ""
    if label_words & _DEPTH:
        return "depth_camera", ""
    if label_words & _HEADSETS:
        return "headset", ""
    if label_words & _ACTION or re.search(r"\bhero ?[0-9]", text):
        return "action", ""
    if label_words & _DRONES:
        return "drone", ""
    if _MODULE.search(text):
        return "camera_module", ""
    mobile = system.name in ("ios", "android")
    if mobile or _PHONES.search(text) or _TABLETS.search(text):
        return _mobile_camera(system, text, label_words)
    if system.is_file:
        return "photo_camera", ""
    vendor = (identity.usb_id or "")[:4]
    if label_words & _BUILT_IN or vendor in _LID_VENDORS:
        return "laptop_builtin", ""
    return ("usb_webcam" if vendor in _VENDORS or identity.distinct else "webcam"), ""


def _mobile_camera(system: System, text: str, label_words: frozenset[str]) -> tuple[str, str]:
    device = "tablet" if _TABLETS.search(text) else "phone"
    if label_words & _FRONT:
        return f"{device}_front", "front"
    if "ultra wide" in text or "ultrawide" in text or "desk view" in text:
        return "phone_ultrawide", "ultrawide"
    if "tele" in text:
        return "phone_tele", "tele"
    return "phone_video" if system.name == "video" else f"{device}_rear", "wide"


def _maker(identity: Identity, text: str, phone: str) -> str:
    vendor = (identity.usb_id or "")[:4]
    if vendor in _VENDORS:
        return _VENDORS[vendor]
    for maker, pattern in _PHONE_MAKERS:
        if pattern.search(phone) or pattern.search(text):
            return maker
    named = words(text)
    return next((maker for maker in _NAMED if maker.casefold() in named), "")


_NAMED = (
    *_VENDORS.values(),
    *("Lenovo", "GoPro", "RunCam", "Caddx", "Foxeer", "DJI", "Samsung", "Google"),
)
