// The end of a practice run: what the application that sent the visitor gets of it, and the way on to a real camera.
import { t } from "../lib/i18n.js";
import { loadSettings } from "../lib/settings.js";
import { isVirtual } from "../lib/camera-name.js";
import { isPracticeReturned } from "./history.js";
import { returnAddress } from "../lib/result/return-address.js";
import { senderName } from "./sender.js";

/** @typedef {import("./state.js").State} State */

/**
 * Says that a practice result is not handed over, and offers the ways on.
 * @param {import("./parts.js").Parts} parts
 * @param {State} state of a capture that is done
 * @param {string | null} returnTo
 */
export async function showPracticeEnd(
  { practiceKept, practiceKeptText, backWithout },
  { capture: { key }, wanted },
  returnTo,
) {
  practiceKept.hidden = true;
  if (!returnTo || !isVirtual(key?.camera ?? "") || isPracticeReturned(returnTo, wanted.camera)) return;
  const { return_origins = [] } = await loadSettings().catch(() => ({ return_origins: [] }));
  const sender = returnAddress(returnTo, location.origin, return_origins);
  if (!sender) return;
  const { host, url, allowed, isHere } = sender;
  practiceKeptText.textContent = t("capture.practice_kept", { host: senderName(sender) });
  practiceKept.hidden = false;
  backWithout.textContent = isHere ? t("capture.go_back") : t("capture.back_without", { host });
  backWithout.hidden = !allowed;
  if (allowed) backWithout.href = url.href;
}
