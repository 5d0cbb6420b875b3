"""Labels under which browsers report cameras on sale, and those that CALIBDB_DATA adds."""

import csv
from dataclasses import dataclass
from typing import Final

import pytest

from tests.helpers.data import data_dir, external_data


@dataclass(frozen=True)
class LabelRow:
    """A label, the system that reports it ("macOS", "macOS(de)"; "" is unknown), and the product it is of."""

    label: str
    system: str
    product: str


#: product: (label, system); a system in parentheses says the language of the label
PRODUCTS: Final[dict[str, tuple[tuple[str, str], ...]]] = {
    "c920": (
        ("HD Pro Webcam C920 (046d:082d)", "Linux"),
        ("Logitech HD Pro Webcam C920 (046d:082d)", "Windows"),
        ("HD Pro Webcam C920 (046D:082D)", "macOS"),
        ("HD Pro Webcam C920", "macOS"),
        ("Logitech HD Pro Webcam C920", "Windows"),
        ("HD Pro Webcam C920", "Linux"),
    ),
    "c922": (
        ("C922 Pro Stream Webcam (046d:085c)", "Linux"),
        ("Logitech C922 Pro Stream Webcam (046d:085c)", "Windows"),
        ("C922 Pro Stream Webcam", "macOS"),
    ),
    "c270": (("Webcam C270 (046d:0825)", "Linux"), ("Logitech Webcam C270 (046d:0825)", "Windows")),
    "c310": (("Webcam C310 (046d:081b)", "Linux"), ("Webcam C310", "Windows")),
    "c525": (("HD Webcam C525 (046d:0826)", "Linux"), ("Logitech HD Webcam C525", "Windows")),
    "c615": (("HD Webcam C615 (046d:082c)", "Linux"), ("HD Webcam C615", "macOS")),
    "c930e": (("Logitech Webcam C930e (046d:0843)", "Linux"), ("Logitech Webcam C930e", "macOS")),
    "brio": (
        ("Logitech BRIO (046d:085e)", "Linux"),
        ("Logitech BRIO (046d:085e)", "Windows"),
        ("Logitech BRIO", "Windows"),
    ),
    "streamcam": (("Logitech StreamCam (046d:0893)", "Windows"), ("Logitech StreamCam", "macOS")),
    "lifecam-hd-3000": (
        ("Microsoft® LifeCam HD-3000 (045e:0779)", "Linux"),
        ("Microsoft LifeCam HD-3000 (045e:0779)", "Windows"),
        ("Microsoft® LifeCam HD-3000(TM)", "Windows"),
    ),
    "lifecam-cinema": (
        ("Microsoft® LifeCam Cinema(TM) (045e:075d)", "Windows"),
        ("Microsoft® LifeCam Cinema(TM)", "Windows"),
    ),
    "kiyo-pro": (("Razer Kiyo Pro (1532:0e05)", "Windows"), ("Razer Kiyo Pro", "macOS")),
    "facecam": (("Elgato Facecam (0fd9:0078)", "Windows"), ("Elgato Facecam", "macOS")),
    "anker-c200": (("Anker PowerConf C200 (291a:3369)", "Windows"), ("Anker PowerConf C200", "macOS")),
    "obsbot-tiny-2": (("OBSBOT Tiny 2 (3564:fef8)", "macOS"), ("OBSBOT Tiny 2", "Windows")),
    "zed-mini": (("ZED-M (2b03:f682)", "Linux"),),
    "kinect": (("Xbox NUI Camera (045e:02ae)", "Linux"),),
    "integrated-b604": (("Integrated Camera (04f2:b604)", "Windows"),),
    "integrated-b61e": (
        ("Integrated Camera (04f2:b61e)", "Linux"),
        ("Integrated Camera: Integrated C (04f2:b61e)", "Linux"),
    ),
    "integrated-9102": (("Integrated Camera (13d3:5406)", "Windows"),),
    "dell-5532": (
        ("Integrated_Webcam_HD (0bda:5532)", "Linux"),
        ("Integrated Webcam (0bda:5532)", "Windows"),
    ),
    "dell-6715": (("Integrated_Webcam_HD (0c45:6715)", "Linux"),),
    "hp-wide": (("HP Wide Vision HD Camera (30c9:000e)", "Windows"),),
    "hp-true": (("HP TrueVision HD (04f2:b40d)", "Windows"),),
    "easycamera-2113": (("Lenovo EasyCamera (5986:2113)", "Windows"),),
    "easycamera-0652": (("Lenovo EasyCamera (5986:0652)", "Linux"),),
    "uvc-b5f7": (("USB2.0 HD UVC WebCam (04f2:b5f7)", "Windows"),),
    "uvc-56a2": (("USB2.0 HD UVC WebCam (13d3:56a2)", "Linux"),),
    "arducam": (("Arducam OV9281 USB Camera (0c45:6366)", "Linux"), ("Arducam OV9281 USB Camera", "Linux")),
    "microdia-6310": (("USB 2.0 Camera (0c45:6310)", "Linux"),),
    "realsense-415": (("Intel(R) RealSense(TM) Depth Camera 415 (8086:0ad3)", "Linux"),),
    "facetime": (("FaceTime HD Camera", "macOS"), ("FaceTime HD Camera", "macOS(fr)")),
    "facetime-8600": (("FaceTime HD Camera (Built-in) (05ac:8600)", "macOS"),),
    "facetime-8514": (("FaceTime HD Camera (Built-in) (05ac:8514)", "macOS"),),
    "macbook-neo": (("MacBook Air Camera (0000:0001)", "macOS"), ("MacBook Air Camera", "macOS")),
    "studio-display": (("Studio Display Camera (05ac:1114)", "macOS"), ("Studio Display Camera", "macOS")),
    "continuity": (
        ("iPhone Camera", "macOS"),
        ("Maria’s iPhone Camera", "macOS"),
        ("Kamera von „iPhone von Jonas“", "macOS(de)"),
    ),
    "iphone-back": (
        ("Back Camera", "iOS"),
        ("Rückseitige Kamera", "iOS(de)"),
        ("後置相機", "iOS(zh)"),
        ("Задня камера", "iOS(uk)"),
        ("Задняя камера", "iOS(ru)"),
        ("Caméra arrière", "iOS(fr)"),
        ("Cámara trasera", "iOS(es)"),
        ("Fotocamera posteriore", "iOS(it)"),
        ("Câmera Traseira", "iOS(pt)"),
        ("背面カメラ", "iOS(ja)"),
        ("후면 카메라", "iOS(ko)"),
        ("后置相机", "iOS(zh)"),
        ("Tylny aparat", "iOS(pl)"),
        ("Arka Kamera", "iOS(tr)"),
    ),
    "iphone-front": (("Front Camera", "iOS"), ("Vorderseitige Kamera", "iOS(de)")),
    "iphone-ultra-wide": (("Back Ultra Wide Camera", "iOS"),),
    "iphone-telephoto": (("Back Telephoto Camera", "iOS"),),
    "android-0": (("camera2 0, facing back", "Android"), ("camera 0, facing back", "Android")),
    "android-1": (("camera2 1, facing front", "Android"), ("camera 1, facing front", "Android")),
    "android-2": (("camera2 2, facing back", "Android"),),
    "obs": (("OBS Virtual Camera", "Windows"), ("OBS Virtual Camera (m-de:vice)", "macOS")),
}
TYPED: Final = tuple(
    LabelRow(label, system, product) for product, rows in PRODUCTS.items() for label, system in rows
)

#: parameters of a fixture that returns `rows(request.param)`
SOURCES: Final = ("typed", pytest.param("external", marks=external_data))


def rows(source: str) -> list[LabelRow]:
    """Labels typed here, or those of CALIBDB_DATA."""
    if source == "typed":
        return list(TYPED)
    with (data_dir() / "labels.csv").open() as file:
        return [
            LabelRow(row["label"], row["platform"], row["same_device_group"])
            for row in csv.DictReader(file)
            if row["label"]
        ]
