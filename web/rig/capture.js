// Capture of a rig on one device: watches its cameras, opens moments if it leads, takes views for them, and delivers them.
import { DetectorError } from "../lib/detector.js";
import { nextFrame } from "../lib/frames.js";
import { lockFocus } from "../lib/camera.js";
import { lenienceAfter } from "../lib/capture/at-target.js";
import { nextProbe } from "../lib/capture/diagnosis.js";
import { motion } from "../lib/capture/stillness.js";
import { isUnavailable } from "../lib/session.js";
import { BLIND, aimAt, answer, isReady, isSeen, observeFrame } from "./moments.js";
import { Outbox } from "./outbox.js";
import { isAccurate, remotePositions, silentPositions } from "./progress.js";

/**
 * @typedef {import("./service.js").RigState} RigState
 * @typedef {import("./moments.js").Sight} Sight
 *
 * @typedef {object} Member one camera of this device
 * @property {number} position
 * @property {string} session id
 * @property {import("./streams.js").Stream} stream
 * @property {import("./figure.js").Figure} figure
 * @property {[number, number]} size px
 * @property {string} camera label
 *
 * @typedef {object} Current moment that is open, as this device sees it
 * @property {string} id
 * @property {number} unopenedAt ms, when it was certainly not open yet
 * @property {number} seenAt ms, when it was seen to be open
 * @property {Map<number, "take" | "miss">} answers of this device's cameras
 * @property {boolean} over
 *
 * @typedef {object} Model all that the page shows of a capture
 * @property {RigState | null} state
 * @property {Map<number, Sight>} sights by position
 * @property {Current | null} moment
 * @property {boolean} opening a moment is being opened
 * @property {boolean} offline
 * @property {number} waiting views on this device
 * @property {{key: string, kind: "good" | "bad" | "plain", values?: Record<string, string | number>} | null} notice
 * @property {boolean} finishing
 *
 * @typedef {object} Resources
 * @property {import("./service.js").RigService} service
 * @property {import("./membership.js").RigRecord} record
 * @property {() => Promise<unknown>} save
 * @property {import("../lib/board.js").SentBoard} board
 * @property {import("../lib/detector.js").Detector} detector
 * @property {Member[]} members
 * @property {import("./virtual-rig.js").VirtualRig | null} virtual
 * @property {AbortSignal} signal
 * @property {(model: Model) => void} onChange
 * @property {(sign: import("../lib/capture/feedback.js").Sign) => void} onSign
 * @property {(error: unknown) => void} onFailure
 * @property {(moment: string, position: number, corners: import("../lib/board-outline.js").Corners, picture: ImageBitmap) => void} onTaken picture: never sent
 */

const POLL_MS = 1_000;
const CHANGED_POLL_MS = 400; // after a change: the next one is near
const OFFLINE_POLL_MS = 2_000;
const WINDOW_MS = 3_800; // for which other devices may answer a moment
const MAX_OPENING_MS = 2_500; // a moment that took longer to open is not answered: nobody holds still for so long
const NOTICE_MS = 6_000;
const SILENT_MS = 30_000; // for which a camera that answers no more is waited for, once there is enough
const STUCK_MS = 20_000; // without a moment, then another target is asked for
const MAX_MOTION_PX = 3; // between the last frame and the one that is taken, at 1280 px width

export class RigCapture {
  #resources;
  #outbox;
  /** @type {Model} */
  model = { state: null, sights: new Map(), moment: null, opening: false, offline: false, waiting: 0, notice: null, finishing: false };
  /** ms, when the last answer was asked for that did not have what came after. */
  #unopenedAt = -Infinity;
  #known = new Set();
  #etag = "";
  #noticedAt = 0;
  #targetSince = 0;
  /** ms, since when the result is accurate enough. */
  #accurateSince = Infinity;
  #isFocused = new Set();
  /** @type {(() => void) | null} */
  #wake = null;

  /** @param {Resources} resources */
  constructor(resources) {
    this.#resources = resources;
    const { record, save, signal, members } = resources;
    this.#outbox = new Outbox({
      send: (letter) => this.#send(letter),
      save: () => {
        record.letters = [...this.#outbox.letters];
        this.model.waiting = this.#outbox.views;
        void save();
        this.#changed();
      },
      onSent: (letter) => this.#delivered(letter),
      onRefused: (letter, error) => this.#refused(letter, error),
      onLink: (offline) => this.#link(offline),
      signal,
    }, record.letters);
    for (const { position } of members) this.model.sights.set(position, BLIND);
    this.model.waiting = this.#outbox.views;
    addEventListener("online", () => this.#hurry(), { signal });
  }

  get #leader() {
    return this.#resources.record.leads ? this.#resources.members[0].session : "";
  }

  get #sights() {
    return [...this.model.sights.values()];
  }

  /** Whether cameras of other devices take part. */
  get #remote() {
    return this.model.state !== null && remotePositions(this.model.state, this.#own).length > 0;
  }

  get #own() {
    return this.#resources.members.map(({ position }) => position);
  }

  /** Runs until the rig is finished. @returns {Promise<RigState | null>} null: ended otherwise */
  async run() {
    void this.#outbox.flush();
    void this.#poll();
    const { signal } = this.#resources;
    while (!signal.aborted && this.model.state?.status !== "finished") await this.#look();
    return signal.aborted ? null : this.model.state;
  }

  // ------------------------------------------------------------------ what the service says

  async #poll() {
    const { service, record, members: [{ session }], signal } = this.#resources;
    while (!signal.aborted && this.model.state?.status !== "finished") {
      const askedAt = performance.now();
      let pause = POLL_MS;
      try {
        const found = await service.state(record.about, session, this.#etag);
        if (signal.aborted) return;
        if (found) {
          this.#etag = found.etag;
          this.#receive(found.state, askedAt);
          pause = CHANGED_POLL_MS;
        }
        this.#unopenedAt = Math.max(this.#unopenedAt, askedAt);
        this.#link(false);
      } catch (error) {
        if (signal.aborted) return;
        if (!isUnavailable(error)) return this.#resources.onFailure(error);
        this.#link(true);
        pause = OFFLINE_POLL_MS;
      }
      await this.#pause(pause);
    }
  }

  /** @param {RigState} state @param {number} askedAt ms */
  #receive(state, askedAt) {
    const { virtual, board, members } = this.#resources;
    const before = JSON.stringify(this.model.state?.target ?? null);
    const opened = state.moment;
    const isFirst = this.model.state === null;
    this.model.state = state;
    if (opened && !this.#known.has(opened.id)) {
      this.#known.add(opened.id);
      // Of one that was open before this page looked, nobody here knows what was seen then.
      if (!isFirst && !this.#resources.record.leads) this.#begin(opened.id, this.#unopenedAt, performance.now());
    }
    for (const { id } of state.moments) this.#known.add(id);
    this.#unopenedAt = Math.max(this.#unopenedAt, askedAt);
    if (JSON.stringify(state.target) !== before) {
      this.#targetSince = performance.now();
      virtual?.follow(state.target?.cameras ?? []);
      for (const { position, size } of members) {
        const target = state.target?.cameras.find((each) => each.position === position) ?? null;
        this.model.sights.set(position, aimAt(this.#sight(position), target, board, size));
      }
    }
    if (!isAccurate(state)) this.#accurateSince = Infinity;
    else if (this.#accurateSince === Infinity) this.#accurateSince = performance.now();
    this.#changed();
  }

  /** Whether the capture ends by itself: cameras that may have views to deliver are waited for. */
  get #isConverged() {
    const { state } = this.model;
    if (!state || !isAccurate(state) || this.#outbox.letters.length > 0) return false;
    return silentPositions(state, this.#own).length === 0 || performance.now() - this.#accurateSince > SILENT_MS;
  }

  /** @param {boolean} offline */
  #link(offline) {
    if (this.model.offline === offline) return;
    this.model.offline = offline;
    if (!offline) {
      this.#notify("rig.online", "good");
      this.#hurry();
    }
    this.#changed();
  }

  /** Asks and sends at once. */
  #hurry() {
    this.#outbox.retry();
    this.#wake?.();
  }

  /** @param {number} ms */
  #pause(ms) {
    return new Promise((/** @type {(value: void) => void} */ resolve) => {
      const timer = setTimeout(resolve, ms);
      this.#wake = () => {
        clearTimeout(timer);
        resolve();
      };
    });
  }

  // ------------------------------------------------------------------ what the cameras see

  async #look() {
    const { members, signal } = this.#resources;
    await nextFrame(members[0].stream.video);
    if (signal.aborted || document.hidden) return;
    for (const stream of new Set(members.map((member) => member.stream))) {
      const own = members.filter((member) => member.stream === stream);
      if (!stream.unchanged) return this.#resources.onFailure(new ResizeError());
      const pictures = await stream.grab();
      for (const [index, member] of own.entries()) await this.#observe(member, pictures[index]);
      if (signal.aborted) return;
    }
    await this.#decide();
    if (this.model.notice && performance.now() - this.#noticedAt > NOTICE_MS) this.model.notice = null;
    this.#changed();
  }

  /** @param {Member} member @param {VideoFrame | ImageBitmap} picture */
  async #observe({ position, stream }, picture) {
    const before = this.#sight(position);
    const detection = await this.#detect(picture, { probe: nextProbe(before.diagnosis, performance.now()) });
    if (!detection) return;
    const time = performance.now();
    const sight = observeFrame(this.#sight(position), detection, time, this.#resources.board, lenienceAfter(time - this.#targetSince));
    this.model.sights.set(position, sight);
    if (sight.stillness.held > 0 && isSeen(sight) && !this.#isFocused.has(stream)) {
      this.#isFocused.add(stream);
      void lockFocus(stream.camera.track);
    }
  }

  /** @param {VideoFrame | ImageBitmap} picture @param {{full?: boolean, probe?: string | null}} options */
  async #detect(picture, options) {
    try {
      return await this.#resources.detector.detect(picture, options);
    } catch (error) {
      if (this.#resources.signal.aborted) return null;
      if (!(error instanceof DetectorError)) throw error;
      this.#resources.onFailure(error);
      return null;
    }
  }

  /** @param {number} position @returns {Sight} */
  #sight(position) {
    return this.model.sights.get(position) ?? BLIND;
  }

  // ------------------------------------------------------------------ moments

  async #decide() {
    const { record, members, signal } = this.#resources;
    const { moment, state, opening, finishing } = this.model;
    if (!state || finishing || signal.aborted) return;
    if (moment && !moment.over) {
      for (const member of members) await this.#answer(member, moment);
      this.#settle(moment);
    } else if (record.leads && this.#isConverged) {
      void this.finish();
    } else if (record.leads && !opening && (!this.model.offline || !this.#remote)) {
      if (isReady(this.#sights, this.#remote)) void this.open();
      else if (performance.now() - this.#targetSince > STUCK_MS && this.#sights.some(isSeen)) void this.skip();
    }
  }

  /** Opens a moment: all cameras that see the board held still take a view. */
  async open() {
    const { record, service, onSign } = this.#resources;
    if (!record.leads || this.model.opening || (this.model.moment && !this.model.moment.over)) return;
    const id = crypto.randomUUID();
    const unopenedAt = performance.now();
    this.#known.add(id);
    onSign("hold");
    if (!this.#remote) {
      // Nobody else waits for it: it can be opened later.
      this.#outbox.post({ kind: "open", moment: id });
      return this.#begin(id, unopenedAt, performance.now());
    }
    this.model.opening = true;
    this.#changed();
    try {
      const state = await service.openMoment(record.about, this.#leader, id);
      this.#receive(state, unopenedAt);
      const took = performance.now() - unopenedAt;
      if (took < MAX_OPENING_MS) this.#begin(id, unopenedAt, performance.now());
      else this.#notify("rig.too_slow", "plain");
    } catch (error) {
      if (!isUnavailable(error)) return this.#resources.onFailure(error);
      this.#link(true);
    } finally {
      this.model.opening = false;
      this.#changed();
    }
  }

  /** @param {string} id @param {number} unopenedAt ms @param {number} seenAt ms */
  #begin(id, unopenedAt, seenAt) {
    this.model.moment = { id, unopenedAt, seenAt, answers: new Map(), over: false };
    if (!this.#resources.record.leads) this.#resources.onSign("hold");
    this.#changed();
  }

  /** @param {Member} member @param {Current} moment */
  async #answer({ position, session, stream, figure }, moment) {
    if (moment.answers.has(position)) return;
    const sight = this.#sight(position);
    const decision = answer(sight, moment, performance.now());
    if (decision === "wait") return;
    if (decision === "miss") return void moment.answers.set(position, "miss");
    const index = this.#resources.members.filter((each) => each.stream === stream).findIndex((each) => each.position === position);
    const pictures = await stream.grab();
    const picture = pictures[index];
    for (const other of pictures) if (other !== picture) other.close();
    const copy = await createImageBitmap(picture);
    const detection = await this.#detect(picture, { full: true });
    if (!detection) return copy.close();
    const corners = { ids: detection.ids, points: detection.points };
    // Between the two frames the hand may have jerked: the next frame may do.
    if (motion(sight.corners, corners) > (MAX_MOTION_PX * sight.width) / 1280) return copy.close();
    moment.answers.set(position, "take");
    this.model.sights.set(position, { ...this.#sight(position), lastTaken: corners });
    this.#outbox.post({ kind: "view", position, session, moment: moment.id, ...corners });
    figure.flash();
    this.#resources.onTaken(moment.id, position, corners, copy);
  }

  /** Ends a moment when nobody is waited for any more. @param {Current} moment */
  #settle(moment) {
    const { members, record, onSign } = this.#resources;
    const { state } = this.model;
    if (!state || moment.answers.size < members.length) return;
    const taken = [...moment.answers].filter(([, each]) => each === "take").map(([position]) => position);
    const there = state.moments.find(({ id }) => id === moment.id)?.positions ?? [];
    const remote = remotePositions(state, this.#own);
    const isAwaited = record.leads ? remote.some((position) => !there.includes(position)) : taken.length + there.length === 0;
    if (isAwaited && performance.now() - moment.seenAt < WINDOW_MS) return;
    moment.over = true;
    const all = new Set([...taken, ...there]).size;
    if (all > 0) {
      // Where it was missed, too: the same hold is not asked for again.
      for (const [position, sight] of this.model.sights) if (isSeen(sight)) this.model.sights.set(position, { ...sight, lastTaken: sight.corners });
      onSign("taken");
      this.#notify("rig.taken", "good", { count: all });
    } else if (record.leads) {
      onSign("refused");
      this.#notify("rig.missed", "bad");
      if (!this.#outbox.withdraw(moment.id)) this.#outbox.post({ kind: "undo", moment: moment.id });
    }
    this.#changed();
  }

  // ------------------------------------------------------------------ what a person asks for

  /** Undoes a moment in all cameras. @param {string} [id] the last one unless told */
  undo(id = this.model.state?.moments.at(-1)?.id ?? this.model.moment?.id) {
    if (!this.#resources.record.leads || !id) return;
    if (!this.#outbox.withdraw(id)) this.#outbox.post({ kind: "undo", moment: id });
    for (const [position, sight] of this.model.sights) this.model.sights.set(position, { ...sight, lastTaken: null });
    if (this.model.moment?.id === id) this.model.moment = null;
    this.#notify("rig.undone", "good");
  }

  /** Asks for another target. */
  async skip() {
    const { service, record } = this.#resources;
    if (!record.leads) return;
    this.#targetSince = performance.now();
    await this.#ask((askedAt) => service.skip(record.about, this.#leader).then((state) => this.#receive(state, askedAt)));
  }

  /** Ends the capture with the moments that are there. */
  async finish() {
    const { service, record } = this.#resources;
    if (!record.leads || this.model.finishing) return;
    this.model.finishing = true;
    this.#changed();
    await this.#outbox.flush();
    await this.#ask((askedAt) => service.finish(record.about, this.#leader).then((state) => this.#receive(state, askedAt)));
    this.model.finishing = false;
    this.#changed();
  }

  /** @param {(askedAt: number) => Promise<void>} request */
  async #ask(request) {
    try {
      await request(performance.now());
    } catch (error) {
      if (this.#resources.signal.aborted) return;
      if (isUnavailable(error)) this.#link(true);
      else this.#notify("rig.refused", "bad", { reason: error instanceof Error ? error.message : String(error) });
    }
  }

  // ------------------------------------------------------------------ the outbox

  /** @param {import("./outbox.js").Letter} letter */
  async #send(letter) {
    const { service, record } = this.#resources;
    const askedAt = performance.now();
    if (letter.kind === "open") return this.#receive(await service.openMoment(record.about, this.#leader, letter.moment), askedAt);
    if (letter.kind === "undo") return this.#receive(await service.undo(record.about, this.#leader, letter.moment), askedAt);
    const { session, moment, ids, points } = letter;
    return service.submit(session, { moment, ids, points });
  }

  /** @param {import("./outbox.js").Letter} letter */
  #delivered(letter) {
    if (letter.kind === "view") this.#wake?.();
  }

  /** @param {import("./outbox.js").Letter} letter @param {import("../lib/api.js").ApiError} error */
  #refused(letter, error) {
    // It was undone meanwhile, or is there already: nothing is lost.
    if (error.kind === "moment-undone" || (letter.kind !== "view" && error.status === 404)) return;
    if ([401, 403, 404].includes(error.status)) return this.#resources.onFailure(error);
    this.#notify("rig.view_refused", "bad", { reason: error.message });
  }

  /** @param {string} key of a message @param {"good" | "bad" | "plain"} kind @param {Record<string, string | number>} [values] */
  #notify(key, kind, values) {
    this.model.notice = { key, kind, values };
    this.#noticedAt = performance.now();
    this.#changed();
  }

  #changed() {
    if (!this.#resources.signal.aborted) this.#resources.onChange(this.model);
  }
}

/** A device was turned: its picture has another size. */
export class ResizeError extends Error {}
