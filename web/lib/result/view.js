// View of a result: what it is and how good, what it does, numbers, figures, views.
import { ApiError } from "../api.js";
import { el } from "../dom.js";
import { onLanguage, pageUrl, t } from "../i18n.js";
import { keepOwn, ownOf } from "../own-calibrations.js";
import { isKnownModel } from "../../sdk/projection.js";
import { isVirtual } from "../camera-name.js";
import { againAddress, card, resultAddress, showAgreement, verdictOf } from "./card.js";
import { codePart } from "./code-part.js";
import { recordPart } from "./download.js";
import { lensPart, numbersPart } from "./numbers-part.js";
import { factsOf, load } from "./source.js";
import { followAgreement } from "./agreement.js";
import { straightPart } from "./straight-part.js";
import { tabs } from "./tabs.js";
import { tiles } from "./tiles.js";
import { listViews, viewsPart } from "./views.js";

/**
 * @import { Result } from "./numbers.js"
 * @import { Choices, Trial } from "./views.js"
 */

/** Shows one result in an element, and whatever is shown there next. */
export class ResultView {
  #root;
  /** @type {Result | null} */
  #result = null;
  /** @type {Trial | null} */
  #trial = null;
  /** Number of trials: the answer to an earlier one is ignored. */
  #tried = 0;
  /** @type {import("./agreement.js").Agreement | null} */
  #agreement = null;
  /** Aborts the requests about the previous result's camera. */
  #following = new AbortController();
  /** @type {(() => void)[]} */
  #held = [];
  /** @type {ReturnType<typeof straightPart> | null} */
  #straight = null;
  #unlisten;

  /** @param {HTMLElement} root */
  constructor(root) {
    this.#root = root;
    this.#unlisten = onLanguage(() => this.#draw());
    root.addEventListener("pointerover", highlight);
  }

  /** @param {Result} result */
  show(result) {
    const same = result.calibration.id !== null && this.#result?.calibration.id === result.calibration.id;
    this.#result = result;
    this.#trial = null;
    this.#tried += 1;
    if (!same) this.#agreement = null;
    this.#draw();
    this.#keep(result);
    void this.#followAgreement(result);
  }

  /** Stores the result in this browser, except of simulated cameras, for the visitor's list. @param {Result} result */
  #keep({ calibration, report, origin, pending }) {
    const { id, camera } = calibration;
    if (id && !pending && origin !== "stored" && !isVirtual(camera)) keepOwn(ownOf({ ...calibration, id }, report));
  }

  /** @param {Result} result */
  async #followAgreement({ calibration }) {
    this.#following.abort();
    const { signal } = (this.#following = new AbortController());
    const key = factsOf(calibration.id)?.cameraKey;
    if (!key || isVirtual(calibration.camera) || this.#agreement?.settled) return;
    try {
      await followAgreement(key, calibration, signal, (agreement) => {
        this.#agreement = agreement;
        this.#showAgreement();
      });
    } catch (error) {
      // The result is complete without the agreement.
      if (!signal.aborted) console.info("no agreement:", String(error));
    }
  }

  #showAgreement() {
    const place = document.getElementById("agreement");
    if (place && this.#result) showAgreement(place, this.#result.calibration, this.#agreement);
  }

  #draw() {
    const result = this.#result;
    if (!result) return;
    this.#release();
    const trial = this.#trial;
    const { id } = result.calibration;
    const { calibration, report } = trial ?? result;
    const pending = result.pending === true && !report;
    const straight = isKnownModel(calibration.distortion_model)
      ? straightPart(calibration, result.picture ?? null, (picture) => this.#another(picture), result.turnOff ?? null)
      : null;
    if (straight) this.#held.push(straight.dispose);
    this.#straight = straight;
    // The report may arrive while the visitor is about to press a button.
    const focused = this.#root.contains(document.activeElement) ? document.activeElement?.id : "";
    const menu = () => /** @type {HTMLDetailsElement | null} */ (this.#root.querySelector("details.more"));
    const isMenuOpen = menu()?.open === true;
    const panels = /** @type {[name: string, content: Node | false][]} */ ([
      ["numbers", numbersPart(calibration, report, { pending })],
      ["lens", isKnownModel(calibration.distortion_model) && lensPart(calibration, report)],
      [
        "views",
        result.report
          ? viewsPart({ ...result, report: result.report }, trial, this.#choices(result))
          : pending && el("p", { class: "muted" }, t("result.loading")),
      ],
      ["code", codePart(calibration, id)],
      ["details", details(result, calibration)],
    ]).flatMap(([name, content]) => (content ? [{ name, title: t(`result.tab_${name}`), content }] : []));
    this.#root.replaceChildren(
      ...[
        card({ ...result, calibration, report }, trial, id),
        result.aside ?? null,
        straight && el("section", { id: "result-straight", "aria-label": t("result.part_straight") }, straight.element),
        report || pending
          ? tiles(calibration, report, /** @type {import("../board.js").Board | null} */ (factsOf(id)?.board ?? null))
          : null,
        tabs(t("result.part_details"), panels),
      ].filter((element) => element !== null),
    );
    this.#showAgreement();
    if (isMenuOpen) menu()?.setAttribute("open", "");
    if (focused) document.getElementById(focused)?.focus();
  }

  /** Shows the changed picture. */
  refresh() {
    this.#straight?.refresh();
  }

  /** Sets whether the picture comes live from the camera. @param {(() => void) | null} turnOff */
  setLive(turnOff) {
    if (!this.#result) return;
    this.#result = { ...this.#result, turnOff };
    const isPressed = document.activeElement?.id === "turn-off";
    this.#inPlace(() => this.#draw(), "result-straight");
    if (isPressed) document.getElementById("trial-picture")?.focus({ preventScroll: true });
  }

  /** Straightens another picture, where it stands. @param {HTMLCanvasElement} picture */
  #another(picture) {
    if (!this.#result) return;
    this.#result.turnOff?.();
    this.#result = { ...this.#result, picture, turnOff: null };
    this.#inPlace(() => this.#draw(), "result-straight");
  }

  /** @param {Result} result @returns {Choices | null} */
  #choices({ calibration, goOn }) {
    const { id } = calibration;
    return id
      ? { choose: (without) => void this.#leaveOut(id, without), goOn, elsewhere: againAddress(calibration) }
      : null;
  }

  /** Shows the result without some views. @param {string} id @param {number[]} without */
  async #leaveOut(id, without) {
    const own = ++this.#tried;
    const result = this.#result;
    const status = document.getElementById("without-status");
    try {
      if (status && without.length) status.textContent = t("result.fitting_without");
      const trial = without.length ? { without, ...(await load(id, without)) } : null;
      if (own !== this.#tried) return;
      this.#trial = trial;
      this.#inPlace(() => this.#draw());
    } catch (error) {
      if (own !== this.#tried || !result || !status) return;
      status.textContent =
        error instanceof ApiError && error.status === 422
          ? t("result.without_impossible", { views: listViews(without) })
          : result.explain(error);
    }
  }

  /**
   * Draws, with the focus and the place on the page where they were.
   * @param {() => void} draw
   * @param {string} [part] id of what stays
   */
  #inPlace(draw, part = "result-views") {
    const { id = "" } = document.activeElement ?? {};
    const place = () => document.getElementById(part)?.getBoundingClientRect().top ?? 0;
    const before = place();
    draw();
    scrollBy(0, place() - before);
    // The pressed button may be gone after its action.
    (
      document.getElementById(id) ??
      document.getElementById("all-again") ??
      document.getElementById("leave-these")
    )?.focus({ preventScroll: true });
  }

  /** Removes the result. */
  clear() {
    this.#release();
    this.#straight = null;
    this.#following.abort();
    this.#tried += 1;
    [this.#result, this.#trial] = [null, null];
    this.#root.replaceChildren();
  }

  close() {
    this.clear();
    this.#unlisten();
  }

  #release() {
    for (const free of this.#held.splice(0)) free();
  }
}

/** The result that was given to others, unchanged. @param {Result} result */
function contributionText({ origin, calibration: { camera, platform, calibrations, reliable } }) {
  if (origin === "practice" || isVirtual(camera)) return t("result.help_practice");
  if (origin === "stored") return t(reliable ? "result.help_ready" : "result.help_stored", { count: calibrations });
  return t(`result.help_${["photographs", "video"].includes(platform) ? "photographs" : origin}`, {
    count: calibrations,
  });
}

/**
 * Details that few visitors need: the inputs, the address, the system, the whole record.
 * @param {Result} result
 * @param {Result["calibration"]} calibration
 */
function details(result, calibration) {
  const { id } = result.calibration;
  return el(
    "div",
    { class: "record" },
    el("p", { id: "summary" }, contributionText(result)),
    el("p", { class: "muted" }, `${calibration.camera} · ${calibration.platform}`),
    id &&
      id !== new URLSearchParams(location.search).get("id") &&
      el("p", {}, el("a", { href: resultAddress(id) }, t("result.address"))),
    recordPart(calibration),
  );
}

/** Marks all figures of the view that one points at. @param {Event} event */
function highlight({ currentTarget, target }) {
  const root = /** @type {HTMLElement} */ (currentTarget);
  const view = target instanceof Element ? target.closest("[data-view]")?.getAttribute("data-view") : null;
  for (const each of root.querySelectorAll("[data-view]"))
    each.classList.toggle("lit", each.getAttribute("data-view") === view);
}
