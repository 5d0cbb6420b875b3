// The target's picture in the target's colour. Done once a target: an SVG filter over the video would be worked out
// again for every frame, and halve the rate where there is no graphics processor.

const TINT_REDUCTION = 2; // a colour laid over a picture needs half of its pixels

/**
 * The service paints white squares green and black ones magenta; here both take the target's colour, the black ones
 * less of it. Where the picture is black, nothing is left.
 * @param {Blob} picture JPEG @param {number[][]} outline of the target, px: nothing is drawn beyond it
 * @param {[number, number]} size of the image in which the outline is, px
 * @returns {Promise<Blob>} PNG, half the size each way
 */
export async function tint(picture, outline, [width, height]) {
  const bitmap = await createImageBitmap(picture);
  const canvas = new OffscreenCanvas(
    Math.ceil(bitmap.width / TINT_REDUCTION),
    Math.ceil(bitmap.height / TINT_REDUCTION),
  );
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) return picture;
  context.beginPath();
  for (const [x, y] of outline)
    context.lineTo(((x + 0.5) * canvas.width) / width, ((y + 0.5) * canvas.height) / height);
  if (outline.length > 2) context.clip();
  context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  bitmap.close();
  const image = context.getImageData(0, 0, canvas.width, canvas.height);
  colour(image.data);
  context.putImageData(image, 0, 0);
  return canvas.convertToBlob({ type: "image/png" });
}

/** @param {Uint8ClampedArray} data rgba, changed in place */
export function colour(data) {
  for (let at = 0; at < data.length; at += 4) {
    const [red, green] = [data[at], data[at + 1]];
    data[at] = 0.72 * red + green;
    data[at + 1] = 0.6 * red + 0.69 * green;
    data[at + 2] = 0.4 * red;
  }
}
