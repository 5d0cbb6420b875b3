// Page of one stored calibration: /result/?id=…
import { ApiError } from "../lib/api.js";
import { el, part } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { sayChosen } from "../lib/file-input.js";
import { sized, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { loadSettings } from "../lib/settings.js";
import { liveRegion } from "../lib/live-region.js";
import words from "../messages/result.js";
import { load } from "../lib/result/source.js";
import { ResultView } from "../lib/result/view.js";

/** @typedef {import("../lib/result/view.js").Result} Result */

openPage({ result: words });
const query = new URLSearchParams(location.search);
const root = part("result", HTMLElement);
const say = liveRegion(part("status", HTMLElement));
const view = new ResultView(root);

/** A picture of this camera to straighten. @param {Result} result */
function offerPicture(result) {
  const [width, height] = result.calibration.img_size;
  const input = part("picture", HTMLInputElement);
  const complain = liveRegion(part("picture-problem", HTMLElement));
  part("trial", HTMLElement).hidden = false;
  sayChosen(input);
  input.addEventListener("change", async () => {
    const [file] = input.files ?? [];
    if (!file) return;
    complain();
    try {
      const picture = await createImageBitmap(file);
      if (picture.width * height !== picture.height * width) {
        complain(() => t("result.picture_shape", { size: sized([width, height]) }));
        return;
      }
      const canvas = el("canvas", { width, height });
      canvas.getContext("2d")?.drawImage(picture, 0, 0, width, height);
      view.show({ ...result, picture: canvas });
      document.getElementById("result-straight")?.scrollIntoView();
    } catch (error) {
      if (!(error instanceof DOMException)) throw error;
      complain(() => t("result.picture_unreadable"));
    }
  });
}

/** Why there is nothing to show, and where to go from here. @param {() => string} why */
function leadOn(why) {
  const ways = el("div", { class: "actions" });
  liveRegion(ways)(() => [el("a", { class: "button", href: "../cameras/" }, t("result.search")),
    el("a", { class: "button", href: "../calibrate/" }, t("result.calibrate"))]);
  part("waiting", HTMLElement).append(ways);
  say(why);
}

async function show() {
  const id = query.get("id");
  if (!id) return leadOn(() => t("result.no_id"));
  const onRetry = (/** @type {object | null} */ retry) => say(() => t(retry ? "faults.retry" : "result.loading"));
  onRetry(null);
  try {
    const [{ calibration, report }, { return_origins: returnOrigins }] = await Promise.all([load(id, [], { onRetry }), loadSettings()]);
    part("waiting", HTMLElement).hidden = true;
    /** @type {Result} */
    const result = { calibration, report, origin: "stored", returnTo: query.get("return_to"), returnOrigins, explain };
    view.show(result);
    offerPicture(result);
  } catch (error) {
    const missing = error instanceof ApiError && error.status === 404;
    leadOn(() => (missing ? t("result.missing") : explain(error)));
  }
}

void show();
