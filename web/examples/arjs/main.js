// The camera's own camera_para.dat, for AR.js.
import { Calibration } from "../../sdk/calibdb.js";
import { cameraParameters } from "../../sdk/adapters/artoolkit.js";
import { part } from "../../lib/dom.js";
import { number, t } from "../../lib/i18n.js";
import { loadSettings } from "../../lib/settings.js";
import { whenOpen } from "../picture.js";

whenOpen(async ({ camera }) => {
  if (!(camera instanceof Calibration)) return; // only a stored calibration has a file
  const { api, token } = await loadSettings();
  const { url, error } = await cameraParameters(camera, { token, api: new URL(api, location.href) });
  const link = part("file", HTMLAnchorElement);
  [link.href, link.download] = [url, "camera_para.dat"];
  part("error", HTMLElement).textContent =
    error < 0.1 ? t("examples.exact") : t("examples.inexact", { error: number(error, 1) });
  part("ready", HTMLElement).hidden = false;
});
