// What came out of a capture: shown at once as the session says it, and in full when the service has sent its report.
import { ApiError, OfflineError } from "../lib/api.js";
import { el } from "../lib/dom.js";
import { learn, t } from "../lib/i18n.js";
import { load } from "../lib/result/source.js";
import { ResultView } from "../lib/result/view.js";
import { SettingsError, loadSettings } from "../lib/settings.js";
import { isVirtual } from "../lib/virtual/camera.js";
import words from "../messages/result.js";

/** @typedef {import("./state.js").State} State */

learn({ result: words });

export class Outcome {
  #view;
  #video;
  #returnTo;
  #asked;
  #onAgain;
  #onWithout;
  /** The capture whose outcome is shown; what arrives for an earlier one comes too late. */
  #shown = 0;

  /**
   * @param {HTMLElement} place @param {HTMLVideoElement} video whose last picture is straightened
   * @param {{returnTo: string | null, asked: string | null, onAgain: () => void, onWithout: (indices: number[]) => void}} options
   *   asked: the camera that the page was opened for; onWithout: go on, but without these views
   */
  constructor(place, video, { returnTo, asked, onAgain, onWithout }) {
    this.#view = new ResultView(place);
    this.#video = video;
    this.#returnTo = returnTo;
    this.#asked = asked;
    this.#onAgain = onAgain;
    this.#onWithout = onWithout;
  }

  /** @param {State} state of a capture that is done */
  show({ session, key }) {
    const { calibration, calibration_id: id, advice = [] } = session ?? {};
    if (!calibration) return;
    const own = ++this.#shown;
    const practice = isVirtual(key?.camera ?? "");
    // An application gets no made-up camera for a real one, only where that is what it asked for.
    const returnTo = practice && key?.camera !== this.#asked ? null : this.#returnTo;
    /** @type {import("../lib/result/view.js").Result} */
    const result = {
      calibration, report: null, picture: still(this.#video, calibration.img_size), notes: advice,
      origin: practice ? "practice" : "added", again: { label: () => t("capture.once_more"), action: this.#onAgain }, goOn: this.#onWithout, explain,
    };
    this.#view.show(result);
    if (!id) return;
    void Promise.all([load(id), loadSettings()]).then(([{ report }, { return_origins: returnOrigins }]) => {
      if (own === this.#shown) this.#view.show({ ...result, report, returnTo, returnOrigins });
    }).catch((error) => console.info("no report:", explain(error)));
  }

  clear() {
    this.#shown += 1;
    this.#view.clear();
  }
}

/** The picture that a video shows now; it stays in this page. @param {HTMLVideoElement} video @param {[number, number]} size px */
function still(video, [width, height]) {
  if (video.videoWidth !== width || video.videoHeight !== height) return null;
  const canvas = el("canvas", { width, height });
  canvas.getContext("2d")?.drawImage(video, 0, 0);
  return canvas;
}

/** @param {unknown} error */
function explain(error) {
  if ([ApiError, OfflineError, SettingsError].some((type) => error instanceof type)) return /** @type {Error} */ (error).message;
  return t("common.went_wrong", { message: String(error) });
}
