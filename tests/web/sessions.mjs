// The service's sessions, in memory.
import { Api } from "../../web/lib/api.js";
import { OfflineError } from "../../web/lib/network.js";
import { json } from "./globals.mjs";

const ERRORS = [3, 1, 0.5, 40]; // px, predicted after each view

export class Sessions {
  /** Views of each session, each with its index. @type {{index: number, ids: number[]}[][]} */
  sessions = [];
  /** Requests, in order. */
  calls = [];
  /** True if the service is unavailable. */
  isAway = false;
  /** True if answers do not arrive. */
  isLosing = false;
  /** Number of sessions that have expired. */
  expired = 0;
  /** Views that one request judges. */
  most = Infinity;
  #isConverged = false;
  api = new Api("https://calibdb.example/v1/", {
    fetch: (address, request) => this.fetch(address, request),
    wait: async () => {},
  });

  /** Reason for which a view is refused; null: it is taken. */
  judge = (_view, _taken) => null;

  /** Numbers of the first corners of the views that each session has. */
  get taken() {
    return this.sessions.map((views) => views.map(({ ids: [id] }) => id));
  }

  /** Bodies of the requests to a call. @param {string} call */
  bodies(call) {
    return this.calls.filter((each) => each.call === call).map(({ body }) => body);
  }

  async fetch(address, { method = "GET", headers, body: text }) {
    const call = `${method} ${String(address).split("/v1")[1]}`;
    const body = text && JSON.parse(text);
    this.calls.push({ call, accept: headers.accept, body });
    if (this.isAway) return json(503, {});
    const answer = this.#answer(call, headers, body);
    if (this.isLosing) throw new OfflineError();
    return answer;
  }

  #answer(call, { authorization, accept }, body) {
    if (call === "POST /auth") return json(201, { session_id: `s${this.sessions.push([])}` });
    const number = Number(authorization.slice("Bearer s".length));
    if (number <= this.expired) return json(403, { type: "https://calibdb.example/problems/session-expired" });
    const views = this.sessions[number - 1];
    if (accept === "image/jpeg") return new Response("picture");
    if (call.startsWith("GET /session/pose")) return json(200, { index: views.length });
    if (call.startsWith("DELETE")) views.splice(Number(call.split("/").at(-1)), 1);
    if (call === "POST /session/finish") this.#isConverged = true;
    if (call === "POST /session/views") {
      views.splice(body.index); // the same view again is answered again
      return json(200, { ...this.#take(views, body), ...this.#state(views) });
    }
    if (call !== "POST /session/batch") return json(200, this.#state(views));
    const results = body.views.slice(0, this.most).map((view) => this.#take(views, view));
    return json(200, { ...this.#state(views), results });
  }

  #take(views, { ids }) {
    const reason = this.judge(ids[0], views.length);
    if (reason) return { accepted: false, reason, index: null, error: null };
    views.push({ index: views.length, ids });
    return { accepted: true, reason, index: views.length - 1, error: ERRORS[views.length - 1] };
  }

  #state(views) {
    return {
      status: this.#isConverged ? "converged" : "capturing",
      calibration_id: this.#isConverged ? "id" : null,
      views: views.map(({ index }) => ({ index })),
      uncertainty: views.length > 0 ? { rms: ERRORS[views.length - 1] } : null,
    };
  }
}
