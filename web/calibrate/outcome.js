// Result of a capture: shown at once as the session has it, and in full when the service has sent its report.
import { Api, ApiError, OfflineError } from "../lib/api.js";
import { publishOnConsent } from "../lib/consent.js";
import { el, part } from "../lib/dom.js";
import { nextFrame } from "../lib/frames.js";
import { t } from "../lib/i18n.js";
import { latest } from "../lib/latest.js";
import { pageTitle } from "../lib/result/card.js";
import { load } from "../lib/result/source.js";
import { ResultView } from "../lib/result/view.js";
import { SettingsError, loadSettings } from "../lib/settings.js";
import { isVirtual } from "../lib/camera-name.js";
import { isPracticeReturned } from "./history.js";

/**
 * @import { Result } from "../lib/result/numbers.js"
 * @import { State } from "./state.js"
 */

export class Outcome {
  #view;
  #video;
  #returnTo;
  #asked;
  #onAgain;
  #onWithout;
  #onConsent;
  #photo;
  #consent = part("asked", HTMLElement);
  /** The last picture, and how it is taken again. @type {ReturnType<typeof still>} */
  #still = null;
  /** Closes the camera whose picture is shown. @type {(() => void) | null} */
  #turnOff = null;
  #complete = latest(async (signal, /** @type {string} */ id, /** @type {Result} */ result) => {
    const [{ report }, { return_origins: returnOrigins }] = await Promise.all([load(id), loadSettings()]);
    if (!signal.aborted) this.#show({ ...result, report, returnOrigins });
  });

  /**
   * @param {HTMLElement} place @param {HTMLVideoElement} video whose last picture is straightened
   * @param {{returnTo: string | null, asked: string | null, onAgain: () => void, onWithout: (indices: number[]) =>
   * void, onConsent: (api: Api) => Promise<unknown>, photo: (index: number) => string | null}} options asked: the
   * camera that the page was opened for; onWithout: continue without these views; onConsent: publish the
   * measurements; photo: picture of a view
   */
  constructor(place, video, { returnTo, asked, onAgain, onWithout, onConsent, photo }) {
    this.#view = new ResultView(place);
    this.#video = video;
    this.#returnTo = returnTo;
    this.#asked = asked;
    this.#onAgain = onAgain;
    this.#onWithout = onWithout;
    this.#onConsent = onConsent;
    this.#photo = photo;
  }

  /** @param {State} state of a capture that is done */
  show({ capture: { session, key }, wanted: { flipped } }) {
    const { calibration, calibration_id: id, advice = [] } = session ?? {};
    if (!calibration) return;
    const practice = isVirtual(key?.camera ?? "");
    const returnTo = practice && !isPracticeReturned(this.#returnTo, this.#asked) ? null : this.#returnTo;
    publishOnConsent(
      session?.licence || practice ? null : async () => this.#onConsent(new Api((await loadSettings()).api)),
    );
    this.#consent.hidden = practice || !id;
    this.#still = still(this.#video, calibration.img_size, flipped === true);
    /** @type {Result} */
    const result = {
      calibration,
      report: null,
      picture: this.#still?.canvas ?? null,
      notes: advice,
      origin: practice ? "practice" : "added",
      ownCameraOffered: practice && this.#returnTo !== null && returnTo === null,
      again: { label: () => t("capture.once_more"), action: this.#onAgain },
      goOn: this.#onWithout,
      photo: this.#photo,
      explain,
      aside: this.#consent,
    };
    this.#complete.cancel();
    document.title = pageTitle(calibration, null);
    this.#show({ ...result, pending: Boolean(id) });
    if (!id) return;
    this.#complete(id, { ...result, returnTo }).catch((error) => {
      console.info("no report:", explain(error));
      this.#show({ ...result, returnTo });
    });
  }

  /** @param {Result} result */
  #show(result) {
    this.#view.show({ ...result, turnOff: this.#turnOff });
  }

  /**
   * Shows the picture of the camera that was just calibrated as it comes, until the visitor turns it off or looks
   * elsewhere.
   * @param {() => void} close the camera
   */
  live(close) {
    const taken = this.#still;
    if (!taken || document.hidden || matchMedia("(prefers-reduced-motion: reduce)").matches) return close();
    const over = new AbortController();
    const follow = async () => {
      for (; !over.signal.aborted; await nextFrame(this.#video)) {
        taken.draw();
        this.#view.refresh();
      }
    };
    const end = () => {
      if (over.signal.aborted) return;
      over.abort();
      close();
      this.#turnOff = null;
      this.#view.setLive(null);
    };
    this.#turnOff = end;
    document.addEventListener("visibilitychange", end, { signal: over.signal });
    addEventListener("pagehide", end, { signal: over.signal });
    this.#view.setLive(end);
    void follow();
  }

  clear() {
    this.#turnOff?.();
    this.#complete.cancel();
    document.title = t("capture.title");
    this.#view.clear();
  }
}

/**
 * Current frame of a video; it stays in this page.
 * @param {HTMLVideoElement} video
 * @param {[number, number]} size px
 * @param {boolean} flip turns it back
 */
function still(video, [width, height], flip) {
  if (video.videoWidth !== width || video.videoHeight !== height) return null;
  const canvas = el("canvas", { width, height });
  const context = canvas.getContext("2d");
  if (flip) context?.transform(-1, 0, 0, 1, width, 0);
  const draw = () => context?.drawImage(video, 0, 0);
  draw();
  return { canvas, draw };
}

/** @param {unknown} error */
function explain(error) {
  if ([ApiError, OfflineError, SettingsError].some((type) => error instanceof type))
    return /** @type {Error} */ (error).message;
  return t("common.went_wrong", { message: String(error) });
}
