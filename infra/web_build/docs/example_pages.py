"""Pages under `/examples/`: one an engine, with its whole source, and one of all."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path

from infra.web_build.docs.markdown import code_block

EXAMPLES = "examples/"
_SHARED = ("picture.js", "board.js")


@dataclass(frozen=True)
class Example:
    """One example.

    `name`: the engine. `has_virtual`: the virtual camera can stand in. `lines`: the code that matters.
    `style`: style sheet of the engine. `demo`: content of the page, by default a camera's image with a scene
    over it. `sources`: scripts that the page shows, below the folder of examples. `lead`: key of the text
    below the heading.
    """

    folder: str
    name: str
    has_virtual: bool
    lines: str
    heading: str = "{name} over a calibrated camera"
    style: str = ""
    demo: str = ""
    sources: tuple[str, ...] = _SHARED
    lead: str = "examples.lead"

    @property
    def title(self) -> str:
        """The heading."""
        return self.heading.format(name=self.name)

    @property
    def message(self) -> str:
        """Key of the heading's text."""
        return f"examples.{self.folder}"

    @property
    def does(self) -> str:
        """Key of the text in the gallery."""
        return f"examples.{self.folder}_does"


_LOOKUP_LINES = """const { calibration } = await lookup(track, { token, exact: true });
const rectifier = await calibration.rectifier();   // straightens the picture, on the GPU
stage.prepend(rectifier.canvas);                   // object-fit: cover; once a frame: rectifier.draw(video)
"""
_IMPORT = 'import { lookup } from "calibdb";\n'
_PAIR = """<div class="stage pair" id="stage" role="img" data-t-label="examples.pair" aria-label="Pair">
          <div><canvas id="left"></canvas><canvas id="right"></canvas></div>
          <canvas id="overlay"></canvas>
        </div>
        <p class="depth" id="depth" aria-live="polite"></p>
        <div class="sliders">
          <label><span data-t="examples.column">Column</span>
            <input id="column" type="range" min="60" max="600" value="346"></label>
          <label><span data-t="examples.row">Row</span>
            <input id="row" type="range" min="20" max="460" value="240"></label>
        </div>
        <p><label class="choice"><input id="rectified" type="checkbox" checked>
          <span data-t="examples.rectified">Rectify the pair</span></label></p>
        <div id="virtual" aria-hidden="true"></div>"""
ENGINES = (
    Example(
        "three",
        "three.js",
        has_virtual=True,
        lines=f"""{_IMPORT}import {{ applyCalibration }} from "calibdb/adapters/three";

{_LOOKUP_LINES}
const camera = new THREE.PerspectiveCamera();
applyCalibration(camera, rectifier, {{ viewport: [stage.clientWidth, stage.clientHeight], fit: "cover" }});
mesh.position.set(x, -y, -z);                      // OpenCV's (x, y, z)""",
    ),
    Example(
        "babylon",
        "Babylon.js",
        has_virtual=True,
        lines=f"""{_IMPORT}import {{ applyCalibration }} from "calibdb/adapters/babylon";

{_LOOKUP_LINES}
const camera = new BABYLON.FreeCamera("camera", BABYLON.Vector3.Zero(), scene);
applyCalibration(camera, rectifier, {{ viewport: [stage.clientWidth, stage.clientHeight], fit: "cover" }});
mesh.position.set(x, -y, z);                       // OpenCV's (x, y, z), in a left-handed scene""",
    ),
    Example(
        "aframe",
        "A-Frame",
        has_virtual=True,
        style="vendor/engines/aframe.css",
        lines=f"""{_IMPORT}import {{ registerCalibrated }} from "calibdb/adapters/aframe";

registerCalibrated(AFRAME);
// <a-scene embedded background="transparent: true">
//   <a-entity id="eye" camera="near: 0.1" calibrated="fit: cover" position="0 0 0"></a-entity>
{_LOOKUP_LINES}document.querySelector("#eye").components.calibrated.use(rectifier);""",
    ),
    Example(
        "arjs",
        "AR.js",
        has_virtual=False,
        heading="AR.js with your own camera_para.dat",
        lead="examples.arjs_lead",
        lines="""import { lookup } from "calibdb";
import { cameraParameters } from "calibdb/adapters/artoolkit";
import { applyCalibration } from "calibdb/adapters/three";

const { calibration } = await lookup(track, { token, exact: true });
const { url, error } = await cameraParameters(calibration, { token });
const [width, height] = calibration.img_size;
const parameters = { cameraParametersUrl: url, canvasWidth: width, canvasHeight: height };
const context = new THREEx.ArToolkitContext(parameters);
const viewport = [canvas.clientWidth, canvas.clientHeight];
context.init(() => applyCalibration(camera, calibration, { viewport }));
// in A-Frame: <a-scene arjs="cameraParametersUrl: …">, with the address that was given""",
    ),
    Example(
        "stereo",
        "Stereo",
        has_virtual=True,
        heading="Depth from a rectified pair",
        lines="""import { rectifyPair, rig } from "calibdb";

const stereo = await rig(id, { token });           // of the page /rig/?id=…
const pair = await rectifyPair(leftVideo, rightVideo, stereo);
stage.append(pair.left, pair.right);               // once a frame: pair.draw()
const disparity = disparityOf(left, right, [u, v]); // a patch, compared along its row
pair.depth(disparity);                             // focal * baseline / disparity""",
        demo=_PAIR,
        sources=("stereo/matching.js", "stereo/pair.js", "board.js"),
        lead="examples.stereo_lead",
    ),
)
_ARJS = """<div id="ready" hidden>
          <p><a class="button primary" id="file" data-t="examples.download">Download camera_para.dat</a></p>
          <p id="error"></p>
        </div>
        <p class="muted" data-t="examples.arjs_note"><code>unsafe-eval</code></p>"""


def example_pages(web: Path) -> Mapping[str, str]:
    """Make the pages, by key. A folder without the examples' scripts has none."""
    if not (web / EXAMPLES / "picture.js").is_file():
        return {}
    made = {f"{EXAMPLES}{one.folder}/index.html": _page(web, one) for one in ENGINES}
    return made | {f"{EXAMPLES}index.html": _index()}


def _page(web: Path, example: Example) -> str:
    others = "&nbsp;· ".join(
        f'<a href="../{one.folder}/">{one.name}</a>' for one in ENGINES if one.folder != example.folder
    )
    style = f'\n  <link rel="stylesheet" href="../../{example.style}">' if example.style else ""
    sources = "".join(
        f'<details><summary><code>{name}</code></summary><div lang="en">'
        f"{code_block((web / EXAMPLES / name).read_text(encoding='utf-8'), 'js')}</div></details>"
        for name in (f"{example.folder}/main.js", *example.sources)
    )
    return _document(
        example.name,
        example.lead,
        "../../",
        f'<link rel="stylesheet" href="../../docs/docs.css">{style}\n'
        '  <script type="module" src="./main.js"></script>',
        f"""      <div class="opening">
        <h1 data-t="{example.message}">{example.title}</h1>
        <p data-t="{example.lead}"></p>
      </div>
      <div class="example">
        <p class="problem" id="problem" role="alert" hidden></p>
        {example.demo or _camera_demo(example)}
        {"" if example.has_virtual else _ARJS}
        <section>
          <h2 data-t="examples.code">What the page does</h2>
          {code_block(example.lines, "js")}
          <p data-t="examples.install"><a href="../../docs/sdk/">SDK</a></p>
        </section>
        <section class="source">
          <h2 data-t="examples.source">The whole source</h2>
          {sources}
        </section>
        <p><a href="../" data-t="examples.all">All examples</a> · {others}</p>
      </div>""",
    )


def _camera_demo(example: Example) -> str:
    virtually = (
        '\n          <a class="button" id="virtually" href="?virtual=1" '
        'data-t="examples.virtual">Try the simulated camera</a>'
        if example.has_virtual
        else ""
    )
    picture = (
        f'<img src="../{example.folder}.jpg" width="480" height="270" alt="">' if example.has_virtual else ""
    )
    return f"""<div class="begin" id="begin">{picture}
          <div class="actions"><button class="primary" id="start" type="button"
            data-t="examples.start">Open the camera</button>{virtually}</div>
        </div>
        <div class="stage" id="stage" role="img"
          data-t-label="examples.scene" aria-label="Scene" hidden></div>
        <p id="choice" hidden><label class="choice"><input id="calibrated" type="checkbox" checked>
          <span data-t="examples.calibrated">Use the calibration</span></label></p>
        <div id="virtual" aria-hidden="true"></div>"""


def _index() -> str:
    cards = [_card("../ar", '<strong data-t="examples.ar"></strong>', "examples.ar_does")]
    for one in ENGINES:
        adapter = re.search(r"calibdb/adapters/\w+", one.lines)
        heading = f'<strong data-t="{one.message}">{escape(one.title)}</strong>'
        words = f"<strong>{one.name}</strong> <code>{adapter[0]}</code>" if adapter else heading
        cards.append(_card(one.folder, words, one.does))
    return _document(
        "Examples",
        "examples.index_lead",
        "../",
        '<script type="module" src="./main.js"></script>',
        f"""      <div class="opening">
        <h1 data-t="examples.index">Examples</h1>
        <p data-t="examples.index_lead"></p>
      </div>
      <ul class="gallery">{"".join(cards)}</ul>""",
    )


def _card(folder: str, words: str, does: str) -> str:
    name = folder.rpartition("/")[2]
    picture = f'<img src="./{name}.jpg" width="480" height="270" alt="" loading="lazy">'
    return f'<li><a href="{folder}/">{picture}{words} <span data-t="{does}"></span></a></li>'


def _document(title: str, lead: str, root: str, head: str, main: str) -> str:
    return f"""<!doctype html>
<html lang="en">
<head>
  <title>{title} · calibDB</title>
  <meta name="description" data-t-content="{lead}" content="">
  <link rel="stylesheet" href="{root}examples/examples.css">
  {head}
</head>
<body>
  <div class="page">
    <header class="masthead"></header>
    <main>
{main}
    </main>
  </div>
</body>
</html>
"""
