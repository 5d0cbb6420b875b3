"""Apple's names of built-in cameras, which Safari gives in the user's language, in English."""

import re

# By language: en, de, fr, es, ca, pt, it, nl, sv/nb/da, fi, pl, cs/sk, hr, hu, ro, tr, ru/uk/bg/kk, el,
# he, ar, hi, th, vi, id/ms, zh, ja, ko. NFKC, case folded; spaces count as one.
_POSITION_WORDS = {
    "back": """
        back, rückseitige, rück, arrière, trasera, posterior, del darrere, traseira, de trás,
        (posteriore), posteriore, aan achterzijde, achterzijde, på baksidan, på baksiden, bagside, bak,
        taka, tylny, zadní, zadná, stražnja, hátsó, hátoldali, spate, arka yüzü, arka, задняя,
        на задней панели, задня, задна, артқы, πίσω, אחורית, الخلفية, خلفية, बैक, ด้านหลัง, mặt sau,
        belakang, 後置, 后置, 背面, 후면
    """,
    "front": """
        front, vorderseitige, vorder, avant, frontal, delantera, dianteira, (anteriore), anteriore,
        aan voorzijde, voorzijde, på framsidan, foran, etu, przedni, přední, predná, prednja, elülső,
        față, ön yüzü, ön, передняя, передня, предна, алдыңғы, μπροστινή, קדמית, الأمامية, أمامية,
        फ़्रंट, फ्रंट, ด้านหน้า, mặt trước, depan, 前置, 前面, 전면
    """,
    "ultra wide": """
        ultra wide, ultra-wide, ultra-weitwinkel, ultraweitwinkel, ultra grand-angle, ultra grand angle,
        ultra gran angular, ultra gran angulares, ultra grande-angular, ultra grande angular,
        con ultra-grandangolo, ultra-grandangolo, ultrabrede, ultravidvinkel, ultralaajakulma,
        ultra szerokokątny, ultraszerokokątny, ultra širokoúhlý, ultra širokouhlá, сверхширокоугольная,
        ультраширокоугольная, надширококутна, ultra geniş, ultra lebar, 超廣角, 超广角, 超広角, 울트라 와이드,
        अल्ट्रा वाइड, มุมกว้างพิเศษ
    """,
    "wide": """
        wide, weitwinkel, grand-angle, grand angle, con gran angular, amb gran angular, gran angular,
        amplia, grande-angular, grande angular, con grandangolo, grandangolo, groothoek, brede,
        vidvinkel, vidvinkels, laajakulmainen, laajakulma, szerokokątny, širokoúhlý, širokouhlá, široka,
        széles látószögű, cu obiectiv superangular, geniş, широкоугольная, ширококутна, широкоъгълна,
        кең бұрышты, ευρεία, רחבה, عريضة, वाइड, มุมกว้าง, rộng, lebar, 廣角, 广角, 広角, 와이드
    """,
    "telephoto": """
        telephoto, tele, téléobjectif, teleobjetivo, con teleobiettivo, teleobiettivo, telefoto,
        телефото, 望遠, 长焦, 長焦, 망원, テレフォト
    """,
    "truedepth": "truedepth, 原深感",
    "dual": """
        dual, double, doble, dupla, doppia, dubbel, dubbele, dobbelt, dobbel, kaksois, duální,
        dwuobiektywowy, duálna, dvostruka, kettős, dublă, çift, двойная, здвоєна, двойна, қос, διπλή,
        כפולה, مزدوجة, ड्युअल, คู่, kép, ganda, dwi, 雙, 双, デュアル, 듀얼
    """,
    "triple": """
        triple, tripla, tripel, kolmois, trójobiektywowy, trojitý, тройная, потрійна, üçlü, τριπλή,
        משולשת, ثلاثية, 三, トリプル, 트리플
    """,
    "camera": """
        camera, kamera, caméra, appareil photo, cámara, càmera, câmera, câmara, fotocamera, aparat,
        fotoaparát, cameră, камера, κάμερα, מצלמה, كاميرا, الكاميرا, कैमरा, กล้อง, 相機,
        相机, 鏡頭相機, 鏡頭, 镜头, カメラ, 카메라
    """,
    "desk view": """
        desk view, schreibtischansicht, di panoramica scrivania, panoramica scrivania,
        vista de escritorio, stolní, bureaubladweergave, デスクビュー, 桌上视角, 桌面顯示
    """,
}
_MEANING = {
    " ".join(word.split()): meaning for meaning, text in _POSITION_WORDS.items() for word in text.split(",")
}
_ANY = re.compile("|".join(re.escape(word) for word in sorted(_MEANING, key=len, reverse=True)))
_NOTHING = re.compile(r"[\s,()·-]*")
_ORDER = (
    *("back", "front", "dual", "triple", "ultra wide", "wide"),
    *("telephoto", "truedepth", "desk view", "camera"),
)
_SIDES, _LENSES = {"back", "front"}, {"ultra wide", "wide", "telephoto", "truedepth"}
CAMERA_WORDS = tuple(
    sorted((w for w, meaning in _MEANING.items() if meaning == "camera"), key=len, reverse=True)
)


def in_english(text: str) -> str | None:
    """Translate a name (case folded) of a built-in camera; None unless every part of it is a known word."""
    if not _NOTHING.fullmatch(_ANY.sub(" ", text)):
        return None
    translated = [_MEANING[match] for match in _ANY.findall(text)]
    meanings = set(translated)
    if len(translated) != len(meanings) or "camera" not in meanings:
        return None
    if "desk view" in meanings:
        return " ".join(m for m in _ORDER if m in meanings) if len(meanings) == 2 else None
    if len(meanings & _SIDES) != 1 or len(meanings & _LENSES) > 1 or {"dual", "triple"} <= meanings:
        return None
    return " ".join(m for m in _ORDER if m in meanings)
