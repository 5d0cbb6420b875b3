// Capture of a rig on one device: watches its cameras, opens moments if it leads, takes views for them, and delivers
// them.
import { Engine } from "../lib/capture/engine.js";
import { lenienceAfter } from "../lib/capture/target.js";
import { explain } from "../lib/faults.js";
import { isUnavailable } from "../lib/session.js";
import { answer, isAtTarget, isReady, isSeen, remoteHold } from "./moments.js";
import { RigLink } from "./link.js";
import { Outbox } from "./outbox.js";
import { Sights } from "./sights.js";
import { isAlone, isComplete, remotePositions, silentPositions } from "./progress.js";

/**
 * @import { Detection, Detector } from "../lib/detector.js"
 * @import { Sight } from "./moments.js"
 * @import { Letter } from "./outbox.js"
 * @import { Stage } from "./progress.js"
 * @import { RigService, RigState } from "./service.js"
 */

/**
 * @typedef {object} Member one camera of this device
 * @property {number} position
 * @property {string} session id
 * @property {import("../lib/capture/streams.js").Stream} stream
 * @property {number} half index of its picture in the stream
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
 * @property {number} patience ms, for which other devices need the board to be still
 * @property {boolean} stalled the detector has stopped, and is restarted
 *
 * @typedef {object} Resources
 * @property {RigService} service
 * @property {import("./membership.js").RigRecord} record
 * @property {() => Promise<unknown>} save
 * @property {import("../lib/board.js").SentBoard} board
 * @property {() => Promise<Detector>} openDetector another one
 *   after it has failed
 * @property {Member[]} members
 * @property {import("./virtual-rig.js").VirtualRig | null} virtual
 * @property {AbortSignal} signal
 * @property {(model: Model) => void} onChange
 * @property {(sign: import("../lib/capture/feedback.js").Sign) => void} onSign
 * @property {(error: unknown) => void} onFailure
 * @property {(moment: string, position: number, corners: import("../lib/board-outline.js").Corners, picture:
 *   ImageBitmap) => void} onTaken picture: never sent
 */

/** A device was turned: its picture has another size. */
export class ResizeError extends Error {}

const WINDOW_MS = 3_800; // for which other devices may answer a moment
const MAX_OPENING_MS = 2_500; // a moment that took longer to open is not answered: the board may have moved
const NOTICE_MS = 6_000;
const SILENT_MS = 30_000; // wait for a camera that has stopped answering, once the views suffice
const STUCK_MS = 20_000; // without a moment, after which the page requests another target

export class RigCapture {
  #resources;
  #outbox;
  /** @type {Model} */
  model = {
    state: null,
    sights: new Map(),
    moment: null,
    opening: false,
    offline: false,
    waiting: 0,
    notice: null,
    finishing: false,
    patience: 0,
    stalled: false,
  };
  #link;
  #sights;
  #engine;
  #known = new Set();
  #noticedAt = 0;
  #target = "";
  #targetSince = 0;
  /** Number of cameras of other devices, and when it changed last. */
  #joined = 0;
  #joinedAt = -Infinity;
  /** Moments in a row that not all other devices have answered: they need more time. */
  #unanswered = 0;
  #asked = Promise.resolve();
  /** ms, since when the result is accurate enough. */
  #completeSince = Infinity;
  #momentAt = performance.now();
  /** Of each moment by its id. @type {Map<string, Stage>} */
  #stages = new Map();

  /** @param {Resources} resources */
  constructor(resources) {
    this.#resources = resources;
    const { record, save, signal, members } = resources;
    this.#outbox = new Outbox(
      {
        send: (letter) => this.#send(letter),
        save: () => {
          record.letters = [...this.#outbox.letters];
          this.model.waiting = this.#outbox.views;
          void save();
          this.#changed();
        },
        onSent: ({ kind }) => kind === "view" && this.#link.hurry(),
        onRefused: (letter, error) => this.#refused(letter, error),
        onLink: (offline) => this.#setOffline(offline),
        signal,
      },
      record.letters,
    );
    this.#link = new RigLink({
      service: resources.service,
      id: record.about,
      session: members[0].session,
      signal,
      onState: (state, unopenedAt) => this.#receive(state, unopenedAt),
      onLink: (offline) => this.#setOffline(offline),
      onFailure: resources.onFailure,
    });
    this.#sights = new Sights(members, resources.board);
    this.#engine = new Engine(this, {
      cameras: members,
      board: () => resources.board,
      openDetector: resources.openDetector,
      signal,
    });
    this.model.sights = this.#sights.all;
    this.model.waiting = this.#outbox.views;
  }

  get #leader() {
    return this.#resources.record.leads ? this.#resources.members[0].session : "";
  }

  /** True if cameras of other devices take part. */
  get #remote() {
    return this.model.state !== null && remotePositions(this.model.state, this.#own).length > 0;
  }

  /** Time for which other devices need the board to be still, ms; 0 where there are none. */
  get #patience() {
    return this.#remote ? remoteHold(this.#unanswered) : 0;
  }

  get #own() {
    return this.#resources.members.map(({ position }) => position);
  }

  /** Runs until the rig is finished. @returns {Promise<RigState | null>} null: ended otherwise */
  async run() {
    void this.#outbox.flush();
    void this.#link.run();
    await this.#engine.run();
    return this.#resources.signal.aborted ? null : this.model.state;
  }

  isOver() {
    return this.model.state?.status === "finished";
  }

  /** @param {Member} camera */
  sight({ position }) {
    return this.#sights.at(position);
  }

  /** @param {Member} camera @param {Detection} detection */
  observe({ position }, detection) {
    this.#sights.observe(position, detection, lenienceAfter(performance.now() - this.#targetSince));
  }

  async act() {
    await this.#decide();
    if (this.#resources.signal.aborted) return;
    if (this.model.notice && performance.now() - this.#noticedAt > NOTICE_MS) this.model.notice = null;
    this.#changed();
  }

  /** True before the first moment while no camera of this device sees a corner. */
  isSearched() {
    const isBlind = this.#sights.list.every(({ corners }) => corners.ids.length === 0);
    return isBlind && !this.model.moment && !this.model.state?.moments.length;
  }

  /** @param {Member} camera @param {import("../lib/board-recognition.js").Recognised | null} suggestion */
  suggest({ position }, suggestion) {
    this.#sights.suggest(position, suggestion);
  }

  /** @param {boolean} stalled */
  onStalled(stalled) {
    this.model.stalled = stalled;
    this.#changed();
  }

  onResized() {
    this.#resources.onFailure(new ResizeError());
  }

  /** @param {RigState} state @param {number} unopenedAt ms, before anything that is new in it was opened */
  #receive(state, unopenedAt) {
    const opened = state.moment;
    const isFirst = this.model.state === null;
    const joined = remotePositions(state, this.#own).length;
    if (joined !== this.#joined) [this.#joined, this.#joinedAt] = [joined, performance.now()];
    if (state.moments.length !== this.model.state?.moments.length) this.#momentAt = performance.now();
    const last = state.moments.at(-1);
    if (last?.positions.length) this.#note(last.id, { rms: state.uncertainty?.rms ?? null });
    this.model.state = state;
    this.model.patience = this.#patience;
    if (opened && !this.#known.has(opened.id)) {
      this.#known.add(opened.id);
      // A moment that was open before this page's first poll is skipped: the page does not know what was seen then.
      if (!isFirst && !this.#resources.record.leads) this.#begin(opened.id, unopenedAt, performance.now());
    }
    for (const { id } of state.moments) this.#known.add(id);
    this.#aim();
    this.#changed();
  }

  /** Shows the state's target; while a moment is open the board stays where it is. */
  #aim() {
    const { state, moment } = this.model;
    const targets = state?.target?.cameras ?? [];
    const target = JSON.stringify(targets);
    if (!state || target === this.#target || (moment && !moment.over)) return;
    this.#target = target;
    this.#targetSince = performance.now();
    this.#resources.virtual?.follow(targets);
    this.#sights.aim(targets);
  }

  /** Records the stage of a moment. @param {string} id @param {Partial<Stage>} stage */
  #note(id, stage) {
    this.#stages.set(id, { rms: null, atTarget: false, ...this.#stages.get(id), ...stage });
  }

  /** True if the capture ends automatically: it waits for cameras that may still deliver views. */
  #checkConverged() {
    const { state } = this.model;
    const now = performance.now();
    const course = state?.moments.map(({ id }) => this.#stages.get(id) ?? { rms: null, atTarget: false }) ?? [];
    if (!state || !isComplete(state, now - this.#momentAt, course)) this.#completeSince = Infinity;
    else if (this.#completeSince === Infinity) this.#completeSince = now;
    if (!state || this.#completeSince === Infinity || this.#outbox.letters.length > 0) return false;
    return silentPositions(state, this.#own).length === 0 || now - this.#completeSince > SILENT_MS;
  }

  /** @param {boolean} offline */
  #setOffline(offline) {
    if (this.model.offline === offline) return;
    this.model.offline = offline;
    if (!offline) {
      this.#notify("rig.online", "good");
      this.#hurry();
    }
    this.#changed();
  }

  /** Polls and sends at once. */
  #hurry() {
    this.#outbox.retry();
    this.#link.hurry();
  }

  async #decide() {
    const { record, members, signal } = this.#resources;
    const { moment, state, opening, finishing } = this.model;
    if (!state || finishing || signal.aborted) return;
    if (moment && !moment.over) {
      for (const member of members) await this.#answer(member, moment);
      this.#settle(moment);
    } else if (record.leads && this.#checkConverged()) {
      void this.finish();
    } else if (record.leads && !opening && this.#isSettled) {
      // A single camera gives no relation to others, and a camera that has just joined has to look first.
      if (isAlone(state) || performance.now() - this.#joinedAt < this.#patience) return;
      const { list } = this.#sights;
      if (isReady(list, this.#patience)) void this.open();
      else if (
        performance.now() - this.#targetSince > STUCK_MS &&
        list.some((sight) => isSeen(sight) || sight.markers > 0)
      )
        void this.skip();
    }
  }

  /**
   * True if the state has the last moment, and so a target after it. Offline, a rig of one device continues.
   */
  get #isSettled() {
    const { moment, state, offline } = this.model;
    if (offline) return !this.#remote;
    if (this.#outbox.letters.length > 0) return false;
    const there = state?.moments.find(({ id }) => id === moment?.id)?.positions ?? [];
    const taken = [...(moment?.answers ?? [])].filter(([, each]) => each === "take").map(([position]) => position);
    return (
      !moment || taken.every((position) => there.includes(position)) || performance.now() - moment.seenAt > WINDOW_MS
    );
  }

  /** Opens a moment: all cameras that see the board held still take a view. */
  async open() {
    const { record, service, onSign } = this.#resources;
    if (!record.leads || this.model.opening || (this.model.moment && !this.model.moment.over)) return;
    const id = crypto.randomUUID();
    const unopenedAt = performance.now();
    this.#known.add(id);
    this.#note(id, { atTarget: isAtTarget(this.#sights.list) });
    onSign("hold");
    if (!this.#remote) {
      // No other device waits for this moment: the service can open it later.
      this.#outbox.post({ kind: "open", moment: id });
      return this.#begin(id, unopenedAt, performance.now());
    }
    this.model.opening = true;
    this.#changed();
    try {
      const state = await service.openMoment(record.about, this.#leader, id);
      this.#link.receive(state, unopenedAt);
      const took = performance.now() - unopenedAt;
      if (took < MAX_OPENING_MS) this.#begin(id, unopenedAt, performance.now());
      else this.#notify("rig.too_slow", "plain");
    } catch (error) {
      if (!isUnavailable(error)) return this.#resources.onFailure(error);
      this.#setOffline(true);
    } finally {
      this.model.opening = false;
      this.#changed();
    }
  }

  /** @param {string} id @param {number} unopenedAt ms @param {number} seenAt ms */
  #begin(id, unopenedAt, seenAt) {
    this.model.moment = { id, unopenedAt, seenAt, answers: new Map(), over: false };
    this.#sights.mark();
    if (!this.#resources.record.leads) this.#resources.onSign("hold");
    this.#changed();
  }

  /** @param {Member} member @param {Current} moment */
  async #answer(member, moment) {
    const { position, session, figure } = member;
    if (moment.over || moment.answers.has(position)) return;
    const decision = answer(this.#sights.at(position), moment, performance.now());
    if (decision === "wait") return;
    if (decision === "miss") return void moment.answers.set(position, "miss");
    const taken = await this.#engine.take(member, { isKept: true });
    if (!taken?.image) return;
    const { corners, image } = taken;
    if (moment.over) return image.close(); // it was undone meanwhile
    moment.answers.set(position, "take");
    this.#outbox.post({ kind: "view", position, session, moment: moment.id, ...corners });
    figure.flash();
    this.#resources.onTaken(moment.id, position, corners, image);
  }

  /** Ends a moment once it waits for no more cameras. @param {Current} moment */
  #settle(moment) {
    const { members, record, onSign } = this.#resources;
    const { state } = this.model;
    if (!state || moment.over || moment.answers.size < members.length) return;
    const taken = [...moment.answers].filter(([, each]) => each === "take").map(([position]) => position);
    const there = state.moments.find(({ id }) => id === moment.id)?.positions ?? [];
    const remote = remotePositions(state, this.#own);
    const isAwaited = record.leads
      ? remote.some((position) => !there.includes(position))
      : taken.length + there.length === 0;
    if (isAwaited && performance.now() - moment.seenAt < WINDOW_MS) return;
    moment.over = true;
    const all = new Set([...taken, ...there]).size;
    if (all > 0) {
      // Also if a camera missed it: the page does not ask for the same hold again.
      this.#sights.take();
      this.#unanswered = remote.every((position) => there.includes(position)) ? 0 : this.#unanswered + 1;
      onSign("taken");
      this.#notify("rig.taken", "good", { count: all });
    } else if (record.leads) {
      onSign("refused");
      this.#notify("rig.missed", "bad");
      if (!this.#outbox.withdraw(moment.id)) this.#outbox.post({ kind: "undo", moment: moment.id });
    }
    this.#aim();
    this.#changed();
  }

  /** Undoes a moment in all cameras. @param {string} [id] the last one by default */
  undo(id = this.model.state?.moments.at(-1)?.id ?? this.model.moment?.id) {
    if (!this.#resources.record.leads || !id) return;
    if (!this.#outbox.withdraw(id)) this.#outbox.post({ kind: "undo", moment: id });
    this.#sights.forget();
    if (this.model.moment?.id === id) {
      this.model.moment.over = true;
      this.model.moment = null;
    }
    this.#notify("rig.undone", "good");
  }

  /** Asks for another target. */
  async skip() {
    const { service, record } = this.#resources;
    if (!record.leads) return;
    this.#targetSince = performance.now();
    await this.#ask((askedAt) =>
      service.skip(record.about, this.#leader).then((state) => this.#link.receive(state, askedAt)),
    );
  }

  /** Ends the capture with the moments that are there. */
  async finish() {
    const { service, record } = this.#resources;
    if (!record.leads || this.model.finishing) return;
    this.model.finishing = true;
    this.#changed();
    await this.#outbox.flush();
    await this.#ask((askedAt) =>
      service.finish(record.about, this.#leader).then((state) => this.#link.receive(state, askedAt)),
    );
    this.model.finishing = false;
    this.#changed();
  }

  /**
   * Sends a request after the one before: the service refuses to finish a rig that changes meanwhile.
   * @param {(askedAt: number) => Promise<void>} request
   */
  #ask(request) {
    return (this.#asked = this.#asked.then(() => this.#attempt(request)));
  }

  /** @param {(askedAt: number) => Promise<void>} request */
  async #attempt(request) {
    try {
      await request(performance.now());
    } catch (error) {
      if (this.#resources.signal.aborted) return;
      if (isUnavailable(error)) this.#setOffline(true);
      else this.#notify("rig.refused", "bad", { reason: explain(error) });
    }
  }

  /** @param {Letter} letter */
  async #send(letter) {
    const { service, record } = this.#resources;
    const askedAt = performance.now();
    if (letter.kind === "open")
      return this.#link.receive(await service.openMoment(record.about, this.#leader, letter.moment), askedAt);
    if (letter.kind === "undo")
      return this.#link.receive(await service.undo(record.about, this.#leader, letter.moment), askedAt);
    const { session, moment, ids, points } = letter;
    return service.submit(session, { moment, ids, points });
  }

  /** @param {Letter} letter @param {import("../lib/api.js").ApiError} error */
  #refused(letter, error) {
    // It was undone meanwhile, or the service has it already: nothing is lost.
    if (error.kind === "moment-undone" || (letter.kind !== "view" && [404, 422].includes(error.status))) return;
    if ([401, 403, 404].includes(error.status)) return this.#resources.onFailure(error);
    this.#notify("rig.view_refused", "bad", { reason: explain(error) });
  }

  /**
   * @param {string} key of a message
   * @param {"good" | "bad" | "plain"} kind
   * @param {Record<string, string | number>} [values]
   */
  #notify(key, kind, values) {
    this.model.notice = { key, kind, values };
    this.#noticedAt = performance.now();
    this.#changed();
  }

  #changed() {
    if (!this.#resources.signal.aborted) this.#resources.onChange(this.model);
  }
}
