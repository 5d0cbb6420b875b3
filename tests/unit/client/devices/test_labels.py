"""Names of cameras: answers of systems lead to the labels that Chromium gives, and so to the same keys.

`system_outputs.json`: `linux` holds what sysfs and VIDIOC_QUERYCAP say of a node, `macos` an entry of
`system_profiler SPCameraDataType -json`, `windows` friendly name and path of Media Foundation. Names and
USB ids are those of labels that browsers were seen to report; the answers around them are written in the
systems' forms, not recorded on these systems.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from calibdb_client import CameraError
from calibdb_client.devices import Device, find, linux, macos, platform_of, windows
from calibdb_client.devices.linux import Capability

OUTPUTS: dict[str, list[dict[str, Any]]] = json.loads(
    (Path(__file__).with_name("system_outputs.json")).read_text(encoding="utf-8")
)


def sysfs(root: Path, node: dict[str, Any], number: int = 0) -> None:
    """Build the part of sysfs that names one node: its folder, its USB interface, its USB device."""
    folder = root / "class" / f"video{number}"
    folder.mkdir(parents=True)
    (folder / "name").write_text(node["card"] + "\n")
    (folder / "index").write_text(f"{node.get('index', 0)}\n")
    usb = root / "devices" / f"1-{number}"
    interface = usb / f"1-{number}:1.0"
    interface.mkdir(parents=True)
    if "usb" in node:
        vendor, product = node["usb"].split(":")
        (usb / "idVendor").write_text(vendor + "\n")
        (usb / "idProduct").write_text(product + "\n")
    if "interface" in node:
        (interface / "interface").write_text(node["interface"] + "\n")
    (folder / "device").symlink_to(interface)


def named(system: str, output: dict[str, Any], root: Path) -> Device:
    """Name the one camera of an output."""
    if system == "linux":
        sysfs(root, output)
        capability = Capability(output["card"], 0x84A00001, output.get("device_caps", 0x04200001))
        (device,) = linux.devices(root / "class", lambda _: capability)
    elif system == "macos":
        (device,) = macos.parse(json.dumps({"SPCameraDataType": [output["entry"]]}).encode())
    else:
        (device,) = windows.name_devices([(0, output["name"], output["path"])])
    return device


CASES = [(system, each) for system, outputs in OUTPUTS.items() for each in outputs]


@pytest.mark.parametrize(
    ("system", "output"), CASES, ids=[f"{system}-{each['label']}" for system, each in CASES]
)
def test_system_gives_the_browsers_label(system: str, output: dict[str, Any], tmp_path: Path) -> None:
    device = named(system, output, tmp_path)
    assert device.label == output["label"]
    assert device.platform == platform_of({"linux": "linux", "macos": "darwin", "windows": "win32"}[system])


def test_nodes_that_deliver_no_pictures_are_left_out(tmp_path: Path) -> None:
    camera = {"card": "HD Pro Webcam C920", "usb": "046d:082d"}
    for number in (0, 1, 2, 10):
        sysfs(tmp_path, {**camera, "index": number % 2}, number)
    (tmp_path / "class" / "v4l-touch0").mkdir()
    caps = {0: 0x04200001, 1: 0x04A00000, 2: 0x04208003, 10: 0x04200001}

    def query(path: Path) -> Capability:
        return Capability(camera["card"], 0x84A00001, caps[int(path.name[5:])])

    assert [each.index for each in linux.devices(tmp_path / "class", query)] == [0, 10]
    unreadable = linux.devices(tmp_path / "class", lambda _: None)
    assert [each.label for each in unreadable] == ["HD Pro Webcam C920 (046d:082d)"] * 3
    assert linux.devices(tmp_path / "absent") == []


def test_camera_is_found_by_index_path_and_name() -> None:
    cameras = [
        Device(0, "Integrated Camera (04f2:b6d0)", "X11; Linux x86_64", "/dev/video0"),
        Device(2, "HD Pro Webcam C920 (046d:082d)", "X11; Linux x86_64", "/dev/video2"),
        Device(4, "HD Pro Webcam C920 (046d:082d)", "X11; Linux x86_64", "/dev/video4"),
    ]
    assert find(0, cameras) is find("0", cameras) is find("/dev/video0", cameras) is cameras[0]
    assert find("integrated", cameras) is cameras[0]
    assert find(4, cameras) is cameras[2]
    with pytest.raises(CameraError, match=r"several cameras are called 'C920'.*2: HD Pro.*4: HD Pro"):
        find("C920", cameras)
    with pytest.raises(CameraError, match="there is no camera '1'; cameras here: 0: Integrated"):
        find(1, cameras)
    with pytest.raises(CameraError, match="cameras here: none"):
        find(0, [])


def test_other_answers_of_macos_are_refused_in_words() -> None:
    for listed in (b"", b"[]", b'{"SPCameraDataType": [{}]}', b'{"SPCameraDataType": ["x"]}'):
        with pytest.raises(CameraError, match="does not know"):
            macos.parse(listed)
