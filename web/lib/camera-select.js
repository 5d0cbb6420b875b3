// List of the cameras of a device in a select element.
import { propose } from "./camera.js";
import { t } from "./i18n.js";

/**
 * Lists the cameras, and proposes one. Until the browser has listed its cameras, nothing is said about them.
 * @param {HTMLSelectElement} select
 * @param {readonly import("./camera.js").Choice[]} choices
 * @param {string | null} asked label of the camera that the page was opened for
 * @returns {boolean} true if there is no camera to propose
 */
export function listCameras(select, choices, asked) {
  const proposed = propose([...choices], asked, select.value);
  select.replaceChildren(
    ...choices.map(({ id, label }) => new Option(id === "virtual" ? t("capture.virtual_name") : label, id)),
  );
  const isListed = choices.length > 0 && choices.every(({ id }) => id !== "");
  const none = proposed === "" && isListed;
  if (none) select.prepend(new Option(t("capture.no_camera"), ""));
  select.value = proposed;
  return none;
}
