// Image input: a photo of one camera that is chosen on this device. It is read here and stays here.
import { el } from "./dom.js";

/**
 * @param {Record<string, string>} attributes of the input
 * @param {readonly [number, number]} size whose shape the image must have, px
 * @param {{onStart?: () => void, onImage: (image: ImageBitmap) => void, onProblem: (problem: "shape" | "unreadable") =>
 *   void}} actions onStart: called when a file is chosen; onImage: takes the image over
 * @returns {HTMLInputElement}
 */
export function imageInput(attributes, [width, height], { onStart = () => {}, onImage, onProblem }) {
  const input = el("input", { type: "file", accept: "image/*", class: "unseen", ...attributes });
  input.addEventListener("change", async () => {
    const [file] = input.files ?? [];
    if (!file) return;
    onStart();
    try {
      const image = await createImageBitmap(file);
      if (image.width * height === image.height * width) return onImage(image);
      image.close();
      onProblem("shape");
    } catch (error) {
      if (!(error instanceof DOMException)) throw error;
      onProblem("unreadable");
    }
  });
  return input;
}
