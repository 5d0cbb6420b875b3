// View of one token: secrets, origins with their proofs, code, use, limits, and its end.
import { button, el } from "../lib/dom.js";
import { offerFile } from "../lib/files.js";
import { joinFacts, hasMessage, language, t } from "../lib/i18n.js";
import { copyButton } from "./copying.js";
import { isLoopback } from "./origins.js";
import { limitsTable } from "./plans.js";
import { SNIPPETS, snippet } from "./snippets.js";
import { KINDS, useChart, useTable } from "./use-chart.js";

/**
 * @import { ManagedToken, OriginState } from "../vendor/api.js"
 * @import { KeptToken } from "./kept-tokens.js"
 * @import { Kind, Period } from "./use-chart.js"
 */

/**
 * @typedef {typeof SNIPPETS[number]} SnippetKind
 *
 * @typedef {object} Choices what is shown of the token
 * @property {SnippetKind} snippet
 * @property {Period} period
 * @property {Kind} kind
 *
 * @typedef {object} Actions
 * @property {() => void} verify
 * @property {(text: string) => void} setOrigins
 * @property {(name: string) => void} setName
 * @property {(graceS: number) => void} rotate
 * @property {() => void} revoke
 * @property {() => void} forget
 * @property {() => void} refresh
 * @property {(choice: Partial<Choices>) => void} choose
 * @property {(what: "code" | "api_token" | "management_token") => void} copied
 */

const GRACES_S = [86_400, 3600, 30 * 86_400, 0]; // s for which the secret until now still opens

/** @param {KeptToken} token */
export const titleOf = ({ name, id }) => name || t("developers.token_named", { id: id.slice(0, 8) });

/** @param {number} seconds unix */
const dateOf = (seconds) =>
  new Intl.DateTimeFormat(language(), { dateStyle: "medium", timeStyle: "short" }).format(new Date(1000 * seconds));

/**
 * @param {KeptToken} token @param {ManagedToken | null} facts null: not known, or not yet
 * @param {Choices} choices @param {Actions} actions
 */
export function tokenView(token, facts, choices, actions) {
  const band = (/** @type {string} */ name, /** @type {(Node | string)[]} */ ...content) =>
    el(
      "section",
      { class: "band", "aria-labelledby": `${name}-heading` },
      el("h3", { id: `${name}-heading` }, t(`developers.part_${name}`)),
      el("div", {}, ...content),
    );
  return el(
    "div",
    { class: "token" },
    el(
      "div",
      { class: "token-title" },
      el("h2", { id: "token-heading", tabindex: -1 }, titleOf(token)),
      facts && factsLine(facts),
    ),
    band("code", ...codePart(token, choices, actions)),
    band("secrets", ...secretsPart(token, actions)),
    ...(token.management_token
      ? [
          band("origins", ...originsPart(token, facts, actions)),
          ...(facts
            ? [
                band("use", ...usePart(facts, choices, actions)),
                band(
                  "limits",
                  el(
                    "div",
                    { class: "wide", tabindex: 0, role: "region", "aria-label": t("developers.limits_of_token") },
                    limitsTable(facts.limits),
                  ),
                ),
              ]
            : []),
          band("change", ...changePart(token, actions)),
        ]
      : [band("change", el("p", {}, t("developers.unmanaged")), forgetButton(actions))]),
  );
}

/** @param {ManagedToken} facts */
function factsLine({ plan, created, expires, former_until: until }) {
  const facts = [
    t("developers.plan", { plan }),
    t("developers.created", { time: dateOf(created) }),
    ...(expires ? [t("developers.expires", { time: dateOf(expires) })] : []),
    ...(until ? [t("developers.former_until", { time: dateOf(until) })] : []),
  ];
  return el("p", { class: "muted", id: "token-facts" }, joinFacts(facts));
}

/** @param {KeptToken} token @param {Choices} choices @param {Actions} actions */
function codePart(token, choices, actions) {
  const text = snippet(choices.snippet, { origin: location.origin, token: token.token });
  const local = token.origins.length > 0 && token.origins.every(isLoopback);
  return [
    el(
      "div",
      { class: "actions" },
      choice(
        "snippet",
        SNIPPETS,
        choices.snippet,
        (kind) => actions.choose({ snippet: kind }),
        (kind) => t(`developers.snippet_${kind}`),
      ),
      copyButton(() => text, t("developers.the_code"), {
        id: "copy-snippet",
        primary: true,
        onCopied: () => actions.copied("code"),
      }),
    ),
    el(
      "div",
      { class: "code" },
      el(
        "pre",
        { tabindex: 0, "aria-label": t(`developers.snippet_${choices.snippet}`) },
        el("code", { id: "snippet" }, text),
      ),
    ),
    el(
      "p",
      { class: "muted" },
      t(
        choices.snippet === "curl"
          ? "developers.about_curl"
          : local
            ? "developers.about_page_local"
            : "developers.about_page",
      ),
    ),
  ];
}

/** @param {KeptToken} token @param {Actions} actions */
function secretsPart(token, actions) {
  /** @param {"api_token" | "management_token"} name @param {string} secret @param {boolean} hidden */
  const row = (name, secret, hidden) => {
    const shown = el("code", { id: `secret-${name}` }, hidden ? mask(secret) : secret);
    const reveal = el("button", { type: "button", "aria-pressed": "false" }, t("developers.reveal"));
    reveal.addEventListener("click", () => {
      const now = reveal.getAttribute("aria-pressed") !== "true";
      reveal.setAttribute("aria-pressed", String(now));
      shown.textContent = now ? secret : mask(secret);
    });
    return el(
      "div",
      { class: "secret" },
      el("h4", {}, t(`developers.secret_${name}`)),
      el("p", { class: "muted" }, t(`developers.about_secret_${name}`)),
      el(
        "div",
        { class: "actions" },
        shown,
        hidden && reveal,
        copyButton(() => secret, t(`developers.secret_${name}`), {
          id: `copy-${name}`,
          onCopied: () => actions.copied(name),
        }),
      ),
    );
  };
  return [
    row("api_token", token.token, false),
    ...(token.management_token ? [row("management_token", token.management_token, true)] : []),
  ];
}

/** @param {string} secret */
const mask = (secret) => `${secret.slice(0, 5)}${"•".repeat(12)}`;

/** @param {KeptToken} token @param {ManagedToken | null} facts @param {Actions} actions */
function originsPart(token, facts, actions) {
  const origins = facts?.origins ?? [];
  const pending = origins.filter(({ state }) => state === "pending");
  const check = button(t("developers.verify"), actions.verify, { id: "verify", class: "primary" });
  const input = el("input", {
    id: "new-origins",
    value: token.origins.join(" "),
    autocomplete: "off",
    autocapitalize: "none",
    spellcheck: false,
    "aria-describedby": "new-origins-problem",
  });
  const form = el(
    "form",
    { class: "change", novalidate: true },
    el(
      "div",
      { class: "field wide-field" },
      el("label", { for: "new-origins" }, t("developers.change_origins")),
      input,
      el("p", { class: "problem", id: "new-origins-problem", role: "alert" }),
    ),
    el("button", { type: "submit" }, t("developers.save")),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    actions.setOrigins(input.value);
  });
  return [
    ...(facts ? [el("ul", { class: "origins" }, ...origins.map(originItem))] : []),
    ...(pending.length
      ? [
          el("div", { class: "actions" }, check, proofFile(pending)),
          el("p", { class: "muted" }, t("developers.proof_text")),
        ]
      : []),
    form,
  ];
}

/** @param {OriginState} state */
function originItem({ origin, state, proof, failure, detail }) {
  const verified = state === "verified";
  const why =
    failure && (hasMessage(`developers.failure_${failure}`) ? t(`developers.failure_${failure}`) : (detail ?? ""));
  return el(
    "li",
    { class: state },
    el("p", {}, el("strong", {}, origin), ` ${t(verified ? "developers.verified" : "developers.pending")}`),
    proof &&
      el(
        "div",
        { class: "proof" },
        el("p", {}, t("developers.place_at")),
        el("code", {}, proof.url),
        el("p", {}, t("developers.place_line")),
        el("code", { class: "proof-line" }, proof.content),
        copyButton(() => proof.content, t("developers.the_line"), { id: `copy-line-${origin}` }),
      ),
    why && el("p", { class: "problem" }, why),
  );
}

/** @param {OriginState[]} pending all of a token have the same line */
function proofFile(pending) {
  const line = pending.find(({ proof }) => proof)?.proof?.content ?? "";
  const save = () => offerFile(new Blob([`${line}\n`], { type: "text/plain" }), "calibdb.txt");
  return button(t("developers.proof_file"), save, { id: "proof-file" });
}

/** @param {ManagedToken} facts @param {Choices} choices @param {Actions} actions */
function usePart({ use }, { period, kind }, actions) {
  const refresh = button(t("developers.refresh"), actions.refresh, { id: "refresh" });
  const select = el(
    "select",
    { id: "kind" },
    ...KINDS.map((each) => new Option(t(`developers.kind_${each}`), each, false, each === kind)),
  );
  select.addEventListener("change", () => actions.choose({ kind: /** @type {Choices["kind"]} */ (select.value) }));
  return [
    el(
      "div",
      { class: "actions" },
      choice(
        "period",
        /** @type {const} */ (["hours", "days"]),
        period,
        (each) => actions.choose({ period: each }),
        (each) => t(`developers.period_${each}`),
      ),
      el("label", { class: "unseen", for: "kind" }, t("developers.calls")),
      select,
      refresh,
    ),
    useChart(use, period, kind),
    el("p", { class: "muted" }, t("developers.about_use")),
    el(
      "details",
      {},
      el("summary", {}, t("developers.as_table")),
      el(
        "div",
        { class: "wide tall", tabindex: 0, role: "region", "aria-label": t(`developers.table_${period}`) },
        useTable(use, period),
      ),
    ),
  ];
}

/** @param {KeptToken} token @param {Actions} actions */
function changePart(token, actions) {
  const name = el("input", { id: "token-name", value: token.name ?? "", maxlength: 80, autocomplete: "off" });
  const naming = el(
    "form",
    { class: "change" },
    el("div", { class: "field" }, el("label", { for: "token-name" }, t("developers.name")), name),
    el("button", { type: "submit" }, t("developers.save")),
  );
  naming.addEventListener("submit", (event) => {
    event.preventDefault();
    if (name.value.trim()) actions.setName(name.value.trim());
  });
  const grace = el(
    "select",
    { id: "grace" },
    ...GRACES_S.map((seconds) => new Option(t(`developers.grace_${seconds}`), String(seconds))),
  );
  const rotate = button(t("developers.rotate"), () => actions.rotate(Number(grace.value)), { id: "rotate" });
  const revoke = button(t("developers.revoke"), actions.revoke, { id: "revoke", class: "danger" });
  return [
    naming,
    el("h4", {}, t("developers.rotate_heading")),
    el("p", { class: "muted" }, t("developers.rotate_text")),
    el(
      "div",
      { class: "change" },
      el("div", { class: "field" }, el("label", { for: "grace" }, t("developers.grace")), grace),
      rotate,
    ),
    el("h4", {}, t("developers.end_heading")),
    el("p", { class: "muted" }, t("developers.end_text")),
    el("div", { class: "actions" }, revoke, forgetButton(actions)),
  ];
}

/** @param {Actions} actions */
const forgetButton = (actions) => button(t("developers.forget"), actions.forget, { id: "forget" });

/**
 * Buttons of which one is pressed.
 * @template {string} C
 * @param {string} name
 * @param {readonly C[]} all
 * @param {C} chosen
 * @param {(choice: C) => void} choose
 * @param {(choice: C) => string} label
 */
function choice(name, all, chosen, choose, label) {
  return el(
    "div",
    { class: "choices", role: "group", "aria-label": t(`developers.choose_${name}`) },
    ...all.map((each) => {
      return button(label(each), () => choose(each), {
        id: `${name}-${each}`,
        "aria-pressed": String(each === chosen),
      });
    }),
  );
}
