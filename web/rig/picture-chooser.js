// Chooser of a picture of one camera: it is read here and stays here.
import { el } from "../lib/dom.js";
import { t } from "../lib/i18n.js";

/**
 * @param {string} words of the button @param {[number, number]} size that the camera's calibration is for, px
 * @param {(picture: ImageBitmap) => void} onPicture @param {(words: string) => void} onProblem
 */
export function chooser(words, [width, height], onPicture, onProblem) {
  const input = el("input", { type: "file", accept: "image/*", class: "unseen" });
  input.addEventListener("change", async () => {
    const [file] = input.files ?? [];
    if (!file) return;
    try {
      const picture = await createImageBitmap(file);
      if (picture.width * height === picture.height * width) return onPicture(picture);
      picture.close();
      onProblem(t("rig.wrong_size", { size: `${width} × ${height}` }));
    } catch (error) {
      if (!(error instanceof DOMException)) throw error;
      onProblem(t("rig.no_image"));
    }
  });
  return el("label", { class: "button" }, words, input);
}
