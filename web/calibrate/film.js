// Progress as a row of thumbnails: pictures of the views taken, the outline of the next target, and room for the
// others.
import { el, make } from "../lib/dom.js";
import { polygon } from "../lib/capture/marks.js";
import { expectedViews, offlineGoal, viewCount } from "./state.js";

/** @import { Event, State } from "./state.js" */

const WIDTH_PX = 240; // px; of a thumbnail, which the result shows larger

/** Pictures stay in this page. */
export class Film {
  #place;
  #video;
  /** Picture of the view that is on its way. */
  #sent = "";
  /** Pictures by the index of their view. @type {Map<number, string>} */
  #pictures = new Map();
  /** Pictures of the views that wait on this device. @type {string[]} */
  #stored = [];

  /** @param {HTMLElement} place @param {HTMLVideoElement} video */
  constructor(place, video) {
    this.#place = place;
    this.#video = video;
  }

  /** Picture of a view of the session, if this page has taken it. @param {number} index */
  picture(index) {
    return this.#pictures.get(index) ?? null;
  }

  /** Takes a picture of each view. @param {Event} event @param {State} state after it */
  follow(event, state) {
    if (event.type === "open") {
      this.#pictures.clear();
      this.#stored = [];
    }
    if (event.type === "sent") this.#sent = this.#take(state);
    if (event.type === "stored") this.#stored.push(this.#take(state));
    if (event.type === "answer" && event.answer.accepted)
      this.#pictures.set(event.answer.views.at(-1)?.index ?? -1, this.#sent);
    if (event.type === "undone" || event.type === "online")
      this.#stored.length = Math.min(this.#stored.length, state.link.stored);
  }

  /** @param {State} state */
  #take({ wanted: { flipped } }) {
    const { videoWidth: width, videoHeight: height } = this.#video;
    if (width === 0) return "";
    const canvas = el("canvas", { width: WIDTH_PX, height: Math.round((WIDTH_PX * height) / width) });
    const context = canvas.getContext("2d");
    if (flipped) context?.transform(-1, 0, 0, 1, WIDTH_PX, 0);
    context?.drawImage(this.#video, 0, 0, canvas.width, canvas.height);
    return canvas.toDataURL("image/jpeg");
  }

  /** @param {State} state */
  render(state) {
    const {
      capture: { session, key, mirrored, progress },
      sight: { aim },
      link: { stored, offline },
    } = state;
    const used = session?.views.filter(({ set_aside }) => !set_aside) ?? [];
    const pictures = [
      ...used.map(({ index }) => this.picture(index)),
      ...Array.from({ length: stored }, (_, index) => this.#stored[index] || null),
    ];
    const count = viewCount(state);
    const total = offline ? used.length + offlineGoal(state) : expectedViews(state);
    const left = Array.from({ length: Math.max(0, total - count) }, (_, index) => {
      const isNext = index === 0 && aim !== null && key !== null;
      return el(
        "i",
        { class: isNext ? "next" : "" },
        isNext &&
          make("svg", { viewBox: `0 0 ${key.img_size.join(" ")}` }, [make("polygon", { points: polygon(aim) })]),
      );
    });
    if (key) this.#place.style.setProperty("--aspect", String(key.img_size[0] / key.img_size[1]));
    this.#place.style.setProperty("--slots", String(pictures.length + left.length));
    this.#place.classList.toggle("mirrored", mirrored);
    this.#place.setAttribute("aria-valuenow", String(Math.round(100 * progress)));
    this.#place.replaceChildren(
      ...pictures.map((picture) =>
        el("i", { class: "taken" }, ...(picture ? [el("img", { src: picture, alt: "" })] : ["✓"])),
      ),
      ...left,
    );
  }
}
