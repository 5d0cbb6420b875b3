"""Environments of a page: a fake camera, no network."""

import json

from playwright.sync_api import FilePayload, Page

LABEL = "HD Pro Webcam C920 (046d:082d)"


def webcam(*labels: str, size: tuple[int, int] = (1280, 720)) -> str:
    """Script that gives a page cameras that look into the dark; the first one is opened."""
    return f"""{{
  const [labels, [width, height]] = [{json.dumps(labels or (LABEL,))}, {list(size)}];
  navigator.mediaDevices.getUserMedia = async () => {{
    const canvas = Object.assign(document.createElement("canvas"), {{ width, height }});
    setInterval(() => canvas.getContext("2d").fillRect(0, 0, width, height), 100);
    const stream = canvas.captureStream(5);
    const [track] = stream.getVideoTracks();
    Object.defineProperty(track, "label", {{ value: labels[0] }});
    track.getSettings = () => ({{ width, height, deviceId: "0" }});
    return stream;
  }};
  navigator.mediaDevices.enumerateDevices = async () =>
    labels.map((label, at) => ({{ kind: "videoinput", deviceId: String(at), label }}));
}}"""


# A detector that is there at once and sees no board: the real one has 3 MB.
BLIND_DETECTOR = """
  const Real = window.Worker;
  window.Worker = class {
    constructor(url, options) {
      if (!String(url).includes("detector.worker")) return new Real(url, options);
    }
    postMessage({ id, frame, recognise }) {
      const size = frame ? [frame.displayWidth ?? frame.width, frame.displayHeight ?? frame.height] : [];
      frame?.close();
      const nothing = recognise
        ? { family: null, markers: [], inverted: false, mirrored: false, chessboard: null, size }
        : { ids: [], points: [], markers: 0, size, elapsed: 1, memory: 0 };
      const result = frame ? nothing : {};
      setTimeout(() => this.onmessage({ data: { id, result } }));
    }
    terminate() {}
  };
"""

# One device that is there or not, and what was asked of it. It has neither id nor name until permitted.
PLUGGED = f"""{webcam()}
  Object.assign(window, {{ there: true, permitted: false }});
  const give = navigator.mediaDevices.getUserMedia;
  navigator.mediaDevices.getUserMedia = (constraints) => {{
    window.asked = constraints.video;
    if (window.refusal) return Promise.reject(new DOMException("", window.refusal));
    window.permitted = true;
    return give();
  }};
  navigator.mediaDevices.enumerateDevices = async () => {{
    const [deviceId, label] = window.permitted ? ["0", "{LABEL}"] : ["", ""];
    return window.there ? [{{ kind: "videoinput", deviceId, label }}] : [];
  }};
"""
# A visitor may be quicker than the list of cameras, which is there after `answer()`.
LISTED_LATE = """
  const list = navigator.mediaDevices.enumerateDevices;
  const listed = new Promise((resolve) => window.answer = resolve);
  navigator.mediaDevices.enumerateDevices = () => listed.then(list);
  window.permitted = true;
"""
PLUG = """(there) => {
  window.there = there;
  navigator.mediaDevices.dispatchEvent(new Event("devicechange"));
}"""


def no_network(page: Page) -> None:
    """Abort all requests to the service."""
    page.route("**/v1/**", lambda route: route.abort("internetdisconnected"))


def unreadable(name: str, kind: str = "") -> FilePayload:
    """File that is not a picture."""
    return {"name": name, "mimeType": kind, "buffer": b"no picture"}
