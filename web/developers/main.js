// Page for developers: makes tokens, keeps them in this browser, and manages the one that is chosen.
import { el, part, liveRegion } from "../lib/dom.js";
import { offerFile } from "../lib/files.js";
import { onLanguage, t } from "../lib/i18n.js";
import { OfflineError } from "../lib/network.js";
import { openPage } from "../lib/page.js";
import { SettingsError, loadSettings, storedSettings } from "../lib/settings.js";
import { askConfirmation } from "./confirmation.js";
import { failureText, originsRefused } from "./errors.js";
import { KeptTokens, STORAGE_KEY, TokenFileError, browserStorage, fileOf, tokensInFile } from "./kept-tokens.js";
import * as management from "./management.js";
import { originsIn } from "./origins.js";
import { planRows } from "./plans.js";
import { titleOf, tokenView } from "./token-view.js";

/**
 * @import { KeptToken } from "./kept-tokens.js"
 * @import { ManagedToken } from "./management.js"
 * @import { Actions, Choices } from "./token-view.js"
 */

const MAX_FILE_BYTES = 1_000_000;
openPage();
const kept = new KeptTokens(browserStorage());
const [panel, list, keptPart] = [part("token", HTMLElement), part("tokens", HTMLElement), part("kept", HTMLElement)];
const [input, makeButton, exportButton, file] = [
  part("origins", HTMLInputElement),
  part("make-button", HTMLButtonElement),
  part("export", HTMLButtonElement),
  part("import", HTMLInputElement),
];
const [tellMade, tellToken, tellKept] = ["made", "token-status", "kept-status"].map((id) =>
  liveRegion(part(id, HTMLElement)),
);
/** @type {Promise<string>} */
const api = apiAddress();
/** @type {Map<string, ManagedToken>} */
const facts = new Map();
/** @type {Choices} */
let choices = { snippet: "page", period: "hours", kind: "lookups" };
let chosen = location.hash.slice(1);
let busy = false;
/** Secrets that only this page has, and that the user has not copied yet. @type {Set<string>} */
const unsaved = new Set();

/** Absolute address of the API, so that a file with tokens names their service. */
async function apiAddress() {
  try {
    return new URL((await loadSettings()).api, location.href).href;
  } catch (error) {
    if (!(error instanceof OfflineError) && !(error instanceof SettingsError)) throw error;
    return new URL(storedSettings()?.api ?? "/v1", location.href).href;
  }
}

/** The token that is shown: the one chosen, else the newest. */
function current() {
  const all = kept.all;
  return all.find(({ id }) => id === chosen) ?? all[0] ?? null;
}

function show() {
  const [all, token] = [kept.all, current()];
  keptPart.hidden = all.length < 2;
  exportButton.disabled = all.length === 0;
  exportButton.hidden = exportButton.disabled;
  list.replaceChildren(
    ...all.map((each) => {
      const button = el(
        "button",
        { type: "button", id: `choose-${each.id}`, "aria-current": each.id === token?.id && "true" },
        titleOf(each),
      );
      button.addEventListener("click", () => choose(each.id));
      return el("li", {}, button, el("span", { class: "muted" }, each.origins.join(" ")));
    }),
  );
  const again = panel.dataset.token === token?.id;
  const [focused, typed] = [document.activeElement?.id, again ? inputsOf(panel) : []];
  panel.dataset.token = token?.id ?? "";
  panel.replaceChildren(...(token ? [tokenView(token, facts.get(token.id) ?? null, choices, actionsOf(token))] : []));
  for (const { id, value } of typed) part(id, HTMLInputElement).value = value;
  if (focused && document.activeElement === document.body)
    document.getElementById(focused)?.focus({ preventScroll: true });
  part("plans", HTMLElement).replaceChildren(...planRows());
}

/** Inputs whose text was typed and not sent yet. @param {HTMLElement} place */
const inputsOf = (place) =>
  [...place.querySelectorAll("input")]
    .filter(({ value, defaultValue }) => value !== defaultValue)
    .map(({ id, value }) => ({ id, value }));

/** @param {string} id */
function choose(id) {
  chosen = id;
  history.replaceState(null, "", `#${id}`);
  tellToken();
  show();
  part("token-heading", HTMLElement).focus();
  void refresh();
}

/** Fetches the facts about the token that is shown. */
async function refresh() {
  const token = current();
  if (!token?.management_token) return;
  try {
    learn(token, await management.show(await api, token.management_token));
  } catch (error) {
    if (current()?.id === token.id) tellToken(() => failureText(error, "other"));
  }
  show();
}

/** @param {KeptToken} token @param {ManagedToken} known */
function learn(token, known) {
  facts.set(token.id, known);
  const kept_ = kept.all.find(({ id }) => id === token.id);
  if (kept_) keep({ ...kept_, name: known.name, origins: known.origins.map(({ origin }) => origin) });
}

/** @param {KeptToken} token */
function keep(token) {
  if (kept.keep(token)) return;
  part("unkept", HTMLElement).hidden = false;
}

/**
 * Runs an action on a token, one at a time.
 * @param {() => Promise<(() => string) | void>} act returns the message to show afterwards
 * @param {"rotate" | "other"} [what] @param {(error: unknown) => boolean} [handled] true if it has handled the error
 */
async function run(act, what = "other", handled = () => false) {
  if (busy) return;
  busy = true;
  panel.setAttribute("aria-busy", "true");
  tellToken(() => t("developers.asking"));
  try {
    const said = await act();
    tellToken(said ?? undefined);
  } catch (error) {
    if (handled(error)) tellToken();
    else tellToken(() => failureText(error, what));
  } finally {
    busy = false;
    panel.removeAttribute("aria-busy");
  }
}

/** @param {KeptToken} token @returns {Actions} */
function actionsOf(token) {
  const secret = token.management_token ?? "";
  return {
    choose: (choice) => {
      choices = { ...choices, ...choice };
      show();
    },
    refresh: () =>
      void run(async () => {
        learn(token, await management.show(await api, secret));
        show();
      }),
    verify: () =>
      void run(async () => {
        const known = await management.verify(await api, secret);
        learn(token, known);
        show();
        const count = known.origins.filter(({ state }) => state === "pending").length;
        return () => (count ? t("developers.unproved", { count }) : t("developers.proved"));
      }),
    setOrigins: (text) => {
      const problem = part("new-origins-problem", HTMLElement);
      const origins = readOrigins(text, part("new-origins", HTMLInputElement), problem);
      if (origins)
        void run(
          async () => {
            learn(token, await management.change(await api, secret, { origins }));
            part("new-origins", HTMLInputElement).value = part("new-origins", HTMLInputElement).defaultValue;
            show();
            return () => t("developers.saved");
          },
          "other",
          (error) =>
            refuse(error, origins, part("new-origins", HTMLInputElement), part("new-origins-problem", HTMLElement)),
        );
    },
    setName: (name) =>
      void run(async () => {
        learn(token, await management.change(await api, secret, { name }));
        part("token-name", HTMLInputElement).value = part("token-name", HTMLInputElement).defaultValue;
        show();
        return () => t("developers.saved");
      }),
    rotate: (graceS) =>
      void run(async () => {
        const made = await management.rotate(await api, secret, graceS);
        keepNew({ ...token, token: made.token }); // before anything else can go wrong
        show();
        await refresh();
        return () => t(graceS ? "developers.rotated" : "developers.rotated_at_once");
      }, "rotate"),
    revoke: async () => {
      if (await ask(token, "revoke"))
        await run(async () => {
          await management.revoke(await api, secret);
          leave(token);
          return () => t("developers.revoked", { name: titleOf(token) });
        });
    },
    forget: async () => {
      if (!(await ask(token, "forget"))) return;
      leave(token);
      tellToken(() => t("developers.forgotten", { name: titleOf(token) }));
    },
    copied: (what) => {
      unsaved.delete(`${token.id} ${what === "code" ? "api_token" : what}`);
    },
  };
}

/** @param {KeptToken} token @param {"revoke" | "forget"} what */
const ask = (token, what) =>
  askConfirmation({
    heading: t(`developers.ask_${what}`, { name: titleOf(token) }),
    text: t(`developers.ask_${what}_text`),
    yes: t(`developers.yes_${what}`),
  });

/** Takes a token off the list. @param {KeptToken} token */
function leave(token) {
  kept.forget(token.id);
  facts.delete(token.id);
  for (const each of [...unsaved]) if (each.startsWith(`${token.id} `)) unsaved.delete(each);
  show();
  part(current() ? "token-heading" : "making", HTMLElement).focus();
  void refresh();
}

/** Stores a new token, whose secrets the user has not seen yet. @param {KeptToken} token */
function keepNew(token) {
  if (kept.keep(token)) return;
  part("unkept", HTMLElement).hidden = false;
  unsaved.add(`${token.id} api_token`).add(`${token.id} management_token`);
}

/**
 * @param {string} text
 * @param {HTMLInputElement} field
 * @param {HTMLElement} problem
 * @returns {string[] | null} null: the problem is shown next to the field
 */
function readOrigins(text, field, problem) {
  const { origins, wrong } = originsIn(text);
  mark(field, problem, wrong && t(`developers.origin_${wrong.fault}`, { origin: wrong.text }));
  if (wrong) return null;
  field.value = origins.join(" ");
  return origins;
}

/** @param {unknown} error @param {string[]} origins @param {HTMLInputElement} field @param {HTMLElement} problem */
function refuse(error, origins, field, problem) {
  const text = originsRefused(error, origins);
  if (text) mark(field, problem, text);
  return text !== null;
}

/** @param {HTMLInputElement} field @param {HTMLElement} problem @param {string | null} text */
function mark(field, problem, text) {
  problem.textContent = text ?? "";
  if (text === null) return field.removeAttribute("aria-invalid");
  field.setAttribute("aria-invalid", "true");
  field.focus();
}

part("make", HTMLFormElement).addEventListener("submit", async (event) => {
  event.preventDefault();
  const problem = part("origins-problem", HTMLElement);
  const origins = readOrigins(input.value, input, problem);
  if (!origins || makeButton.disabled) return;
  makeButton.disabled = true;
  tellMade(() => t("developers.asking"));
  try {
    const address = await api;
    const { id, token, management_token, name } = await management.create(address, origins);
    keepNew({ id, token, management_token, name, origins, api: address }); // before anything else can go wrong
    tellMade();
    choose(id);
    tellToken(() => t("developers.made"));
  } catch (error) {
    if (refuse(error, origins, input, problem)) tellMade();
    else tellMade(() => failureText(error, "create"));
  } finally {
    makeButton.disabled = false;
  }
});

exportButton.addEventListener("click", () => {
  offerFile(new Blob([fileOf(kept.all)], { type: "application/json" }), "calibdb-tokens.json");
  unsaved.clear();
  tellKept(() => t("developers.exported"));
});

file.addEventListener("change", async () => {
  const [given] = file.files ?? [];
  file.value = "";
  if (!given) return;
  try {
    if (given.size > MAX_FILE_BYTES) throw new TokenFileError("unreadable");
    const { tokens, elsewhere } = tokensInFile(await given.text(), await api);
    for (const token of tokens) await load(token);
    const count = tokens.length;
    tellKept(() =>
      [
        t("developers.imported", { count }),
        ...(elsewhere ? [t("developers.left_out", { count: elsewhere })] : []),
      ].join(" "),
    );
    show();
    void refresh();
  } catch (error) {
    if (!(error instanceof TokenFileError)) throw error;
    tellKept(() => t(`developers.file_${error.code}`, { service: error.detail }));
  }
});

/**
 * Stores a token of a file. It replaces another secret of the same token only on request.
 * @param {KeptToken} token
 */
async function load(token) {
  const before = kept.all.find(({ id }) => id === token.id);
  const other = before && before.token !== token.token;
  if (
    other &&
    !(await askConfirmation({
      heading: t("developers.ask_replace", { name: titleOf(before) }),
      text: t("developers.ask_replace_text"),
      yes: t("developers.yes_replace"),
    }))
  )
    return;
  keep({ ...before, ...token, management_token: token.management_token ?? before?.management_token });
}

addEventListener("storage", ({ key }) => {
  if (key === STORAGE_KEY || key === null) show();
});
addEventListener("beforeunload", (event) => {
  if (unsaved.size > 0) event.preventDefault();
});
onLanguage(show);
show();
makeButton.disabled = false; // an earlier click would submit the form without a handler
void refresh();
