// Stage of an immersive session: the camera's picture, the scene and the page's own text, over the whole window.

const FULL = { position: "fixed", inset: "0", width: "100%", height: "100%", margin: "0" };
const PICTURE = { ...FULL, objectFit: "cover" };
const LAYER = { ...FULL, maxWidth: "none", objectFit: "fill" }; // as a framebuffer of the window's, whatever its size
const TOP = "2147483647";

export class Stage {
  #element = document.createElement("div");
  #video;
  #layer;
  #homes;
  /** @type {HTMLElement | undefined} */
  #cover;

  /**
   * @param {HTMLElement} place @param {HTMLVideoElement} video @param {HTMLCanvasElement} layer
   * @param {HTMLElement | null} [overlay] what of the page stays over it
   */
  constructor(place, video, layer, overlay = null) {
    this.#video = video;
    this.#layer = layer;
    // The overlay may be all of the page; the stage is under it then.
    const under = overlay?.contains(place);
    Object.assign(this.#element.style, FULL, { zIndex: under ? "-1" : TOP, background: "black" });
    this.#homes = [this.#dressed(video, PICTURE), this.#dressed(layer, LAYER)];
    if (overlay && !under) this.#homes.push(this.#over(overlay));
    place.append(this.#element);
    this.#play();
  }

  /** Size of the part of the window that it covers, px of CSS. @returns {[number, number]} */
  get size() {
    return [this.#element.clientWidth, this.#element.clientHeight];
  }

  /**
   * Shows another picture in the video's place.
   * @param {HTMLElement | OffscreenCanvas} [picture] undefined: the video's again
   */
  cover(picture) {
    if (picture === this.#cover) return;
    this.#cover?.remove();
    this.#cover = picture instanceof HTMLElement ? picture : undefined;
    if (!this.#cover) return;
    Object.assign(this.#cover.style, PICTURE);
    this.#element.insertBefore(this.#cover, this.#layer);
  }

  /** Puts everything back where it was. */
  leave() {
    for (const home of this.#homes.reverse()) home(); // the last first: the place of one may be next to another
    this.#element.remove();
    this.#play();
  }

  /** Moving the video has paused it. If it is stopped before it plays, that is not an error. */
  #play() {
    this.#video.play().catch(() => {});
  }

  /** @param {HTMLElement} element @param {Partial<CSSStyleDeclaration>} style @returns {() => void} puts it back */
  #dressed(element, style) {
    const worn = element.getAttribute("style") ?? "";
    Object.assign(element.style, style);
    const home = moved(element, this.#element);
    return () => {
      element.style.cssText = worn;
      home();
    };
  }

  /** Puts the overlay into a frame of its own, because its style belongs to the page. @param {HTMLElement} overlay */
  #over(overlay) {
    const frame = document.createElement("div");
    Object.assign(frame.style, FULL);
    this.#element.append(frame);
    return moved(overlay, frame);
  }
}

/** @param {HTMLElement} element @param {HTMLElement} place @returns {() => void} puts it back */
function moved(element, place) {
  const { parentNode, nextSibling } = element;
  place.append(element);
  return () => {
    if (parentNode) parentNode.insertBefore(element, nextSibling?.parentNode === parentNode ? nextSibling : null);
    else element.remove();
  };
}
