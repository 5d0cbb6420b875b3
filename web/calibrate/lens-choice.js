// Type of the lens: chosen on the first sheet, or detected, which applies the service's suggestion automatically.
import { isLensType } from "../lib/lens-types.js";

/** @typedef {import("./state.js").State} State */

/** Views from which a type of lens is detected: with fewer, noise may look like a lens. */
const MIN_DETECTING_VIEWS = 3;

/**
 * Lets the visitor choose, and keeps the choice in the page's address.
 * @param {HTMLSelectElement} select its values are types, "" that it is detected
 * @param {URLSearchParams} parameters of the address
 * @param {(chosen: {model: State["wanted"]["distortion_model"], automatic: boolean}) => void} onChoice
 */
export function offerLensTypes(select, parameters, onChoice) {
  const asked = parameters.get("distortion_model") ?? "";
  select.value = isLensType(asked) ? asked : "";
  select.addEventListener("change", () => {
    const { value } = select;
    if (isLensType(value)) parameters.set("distortion_model", value);
    else parameters.delete("distortion_model");
    onChoice({ model: isLensType(value) ? value : "rectilinear", automatic: !isLensType(value) });
  });
}

/** True if a type is suggested that is to be taken without a question. @param {State} state */
export function isLensDetected({ phase, capture: { session }, wanted }) {
  return (
    wanted.automatic &&
    (phase === "capturing" || phase === "done") &&
    (session?.views.length ?? 0) >= MIN_DETECTING_VIEWS &&
    (session?.suggested_model ?? wanted.distortion_model) !== wanted.distortion_model
  );
}
