// Page of the database: /cameras/ searches, /cameras/?key=… shows one camera.
import { ApiError } from "../lib/api.js";
import { el, part } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { onLanguage, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { liveRegion } from "../lib/live-region.js";
import { isVirtual } from "../lib/virtual/name.js";
import words from "../messages/cameras.js";
import result from "../messages/result.js";
import { cameraView, nameOf } from "./camera.js";
import { camera, search } from "./source.js";

/** @typedef {import("./source.js").Found} Found */

const TYPING_PAUSE_MS = 250; // ms after the last key
openPage({ cameras: words, result });
const [searching, status, list, one] = ["searching", "status", "found", "one"].map((id) => part(id, HTMLElement));
const [input, more] = [part("query", HTMLInputElement), part("more", HTMLButtonElement)];
const tell = liveRegion(status);
/** @type {Found[]} */
let found = [];
/** @type {string | null} */
let next = null;
/** @type {import("./source.js").CameraPage | null} */
let shown = null;
/** The current request; an answer to anything else comes too late. */
let asked = 0;

/** @param {string} key */
const address = (key) => `./?${new URLSearchParams({ key })}`;

/** @param {Found} camera */
function item({ key, camera: name, platform, sizes }) {
  const calibrations = sizes.reduce((sum, each) => sum + each.calibrations, 0);
  return el("li", {},
    el("a", { href: address(key) }, el("strong", {}, name), el("span", { class: "muted" }, [platform, ...(isVirtual(name) ? [t("cameras.practice")] : [])].join(" · "))),
    el("ul", { class: "sizes number" }, ...sizes.map((size) =>
      el("li", { class: size.reliable ? "known" : "" }, nameOf({ ...size, groups: [], consensus: {}, members: [] }),
        el("span", { class: "unseen" }, ` ${t(size.reliable ? "cameras.reliable" : "cameras.unreliable")}`)))),
    el("span", { class: "count number muted" }, t("cameras.calibrations", { count: calibrations })));
}

function showList() {
  list.replaceChildren(...found.map(item));
  more.hidden = next === null;
  part("legend", HTMLElement).hidden = !found.some(({ sizes }) => sizes.some(({ reliable }) => reliable));
}

/** @param {{further?: boolean}} [options] */
async function look({ further = false } = {}) {
  const own = ++asked;
  const wait = (/** @type {object | null} */ retry) => own === asked && tell(() => t(retry ? "faults.retry" : "cameras.searching"));
  if (!further) wait(null);
  try {
    const answer = await search(input.value.trim(), further ? next : null, wait);
    if (own !== asked) return;
    found = further ? [...found, ...answer.cameras] : answer.cameras;
    next = answer.next;
    // Where many names begin with the first word, a page of answers may hold none of them.
    if (answer.cameras.length === 0 && next !== null) return await look({ further: true });
    showList();
    const named = input.value.trim() !== "";
    tell(() => (found.length ? "" : t(named ? "cameras.none" : "cameras.empty")));
  } catch (error) {
    if (own === asked) tell(() => explain(error));
  }
}

/** Why there is nothing to show, and where to go from here. */
function leadOn() {
  const ways = el("div", { class: "actions" });
  liveRegion(ways)(() => [el("a", { class: "button", href: "./" }, t("cameras.search_all")),
    el("a", { class: "button", href: "../calibrate/" }, t("cameras.calibrate"))]);
  part("waiting", HTMLElement).append(ways);
}

/** @param {string} key */
async function show(key) {
  searching.hidden = true;
  const waiting = part("waiting", HTMLElement);
  waiting.hidden = false;
  const say = liveRegion(part("waiting-text", HTMLElement));
  const wait = (/** @type {object | null} */ retry) => say(() => t(retry ? "faults.retry" : "cameras.loading"));
  wait(null);
  try {
    shown = await camera(key, wait);
    document.title = `${shown.camera} · calibDB`;
    waiting.hidden = true;
    one.replaceChildren(cameraView(shown, explain));
  } catch (error) {
    const missing = error instanceof ApiError && error.status === 404;
    say(() => (missing ? t("cameras.missing") : explain(error)));
    leadOn();
  }
}

/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;
input.addEventListener("input", () => {
  clearTimeout(timer);
  timer = setTimeout(look, TYPING_PAUSE_MS);
});
part("search", HTMLFormElement).addEventListener("submit", (event) => {
  event.preventDefault();
  clearTimeout(timer);
  void look();
});
more.addEventListener("click", () => look({ further: true }));
onLanguage(() => (shown ? one.replaceChildren(cameraView(shown, explain)) : showList()));
const parameters = new URLSearchParams(location.search);
const key = parameters.get("key");
if (key) void show(key);
else {
  input.value = parameters.get("query") ?? "";
  void look();
}
