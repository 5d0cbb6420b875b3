"""A camera node in the manner of ROS 2, without ROS: it looks its camera up, and publishes CameraInfo.

    python ros_camera_info.py --label "HD Pro Webcam C920 (046d:082d)" --size 1280x720

The YAML is the one that camera_info_manager reads (camera_info_url: file://…/webcam.yaml).
"""

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from calibdb_client import Calibration, CameraKey, Client


class CameraInfoNode:
    """Publishes CameraInfo with every image. In a real node `publish` is that of an rclpy publisher."""

    def __init__(self, name: str, folder: Path, publish: Callable[[dict[str, Any]], object]) -> None:
        self.name, self.folder, self.publish = name, folder, publish
        self.info: dict[str, Any] = {}

    def configure(self, client: Client, key: CameraKey) -> bool:
        """Look the camera up and write its file; False if nothing reliable is known."""
        answer = client.lookup(key)
        if answer.calibration is None:
            print(f"{key.camera}: {answer.detail} Calibrate it: {answer.guidance_url}")
            return False
        self.use(answer.calibration)
        return True

    def use(self, calibration: Calibration) -> None:
        """Write the file of camera_info_manager, and take over the message's fields."""
        self.folder.mkdir(parents=True, exist_ok=True)
        calibration.save(self.folder / f"{self.name}.yaml", format="ros")
        self.info = calibration.camera_info()

    def on_image(self, seconds: int, nanoseconds: int) -> None:
        """Publish the CameraInfo of an image, with the image's own stamp."""
        stamp = {"sec": seconds, "nanosec": nanoseconds}
        self.publish({"header": {"stamp": stamp, "frame_id": self.name}, **self.info})


def main() -> int:
    """Run the node for one image."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--label", required=True)
    parser.add_argument("--platform", default="X11; Linux x86_64")
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--name", default="webcam")
    parser.add_argument("--folder", type=Path, default=Path("~/.ros/camera_info").expanduser())
    chosen = parser.parse_args()
    w, h = (int(side) for side in chosen.size.split("x"))
    node = CameraInfoNode(chosen.name, chosen.folder, lambda message: print(json.dumps(message)))
    with Client() as client:
        if not node.configure(client, CameraKey(chosen.label, chosen.platform, (w, h))):
            return 1
    node.on_image(0, 0)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
