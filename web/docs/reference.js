// The API reference: one language for all examples, and requests that are sent from the page.
import { el } from "../lib/dom.js";
import { keepItem, readItem } from "../lib/storage.js";
import { chosenToken } from "./tokens.js";

const LANGUAGE = "calibdb.docs.language";
const TIMEOUT_MS = 30_000;
const SHOWN_HEADERS = ["ratelimit", "retry-after", "location", "x-conversion-error"];

/** Values that answers gave to later requests. @type {{session?: string, id?: string, key?: string, rig?: string}} */
const learnt = {};

rememberLanguage();
for (const form of /** @type {NodeListOf<HTMLFormElement>} */ (document.querySelectorAll("form[data-operation]")))
  offer(form);
addEventListener("calibdb-token", fillCredentials);
fillCredentials();

/** Shows all examples in the language chosen last. */
function rememberLanguage() {
  const choose = (/** @type {string} */ name) => {
    for (const input of /** @type {NodeListOf<HTMLInputElement>} */ (
      document.querySelectorAll(".samples input[type=radio]")
    )) {
      if (input.value === name) input.checked = true;
    }
  };
  choose(readItem(LANGUAGE) ?? "");
  document.addEventListener("change", ({ target }) => {
    if (!(target instanceof HTMLInputElement) || !target.matches(".samples input")) return;
    choose(target.value);
    keepItem(LANGUAGE, target.value);
  });
}

/** Fills in the credentials that are known, where the visitor typed none. */
function fillCredentials() {
  const chosen = chosenToken();
  const known = {
    apiToken: chosen?.token,
    apiTokenInQuery: chosen?.token,
    managementToken: chosen?.management_token,
    sessionId: learnt.session,
  };
  for (const form of /** @type {NodeListOf<HTMLFormElement>} */ (document.querySelectorAll("form[data-credential]"))) {
    const field = form.elements.namedItem("credential");
    const value = known[/** @type {keyof typeof known} */ (form.dataset.credential)];
    if (field instanceof HTMLInputElement && value && !field.dataset.typed) field.value = value;
    for (const name of /** @type {const} */ (["id", "key"])) {
      const place = form.elements.namedItem(`path-${name}`);
      const value = name === "id" && form.dataset.path?.startsWith("/v1/rigs/") ? learnt.rig : learnt[name];
      if (place instanceof HTMLInputElement && value && !place.value) place.value = value;
    }
  }
}

/** @param {HTMLFormElement} form */
function offer(form) {
  const field = form.elements.namedItem("credential");
  if (field instanceof HTMLInputElement) field.addEventListener("input", () => (field.dataset.typed = "true"));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    void send(form);
  });
}

/** @param {HTMLFormElement} form */
async function send(form) {
  const output = /** @type {HTMLElement} */ (form.querySelector(".trial-answer"));
  const button = /** @type {HTMLButtonElement} */ (form.querySelector("button"));
  const { method = "GET", path = "", operation = "", accept = "application/json" } = form.dataset;
  const data = new FormData(form);
  const text = (/** @type {string} */ name) => String(data.get(name) ?? "").trim();
  const url = new URL(
    path.replace(/\{(\w+)\}/g, (_, name) => encodeURIComponent(text(`path-${name}`))),
    location.origin,
  );
  for (const name of data.keys()) {
    if (name.startsWith("query-") && text(name)) url.searchParams.set(name.slice("query-".length), text(name));
  }
  /** @type {Record<string, string>} */
  const headers = { accept };
  if (text("credential")) headers.authorization = `Bearer ${text("credential")}`;
  if (data.has("body")) headers["content-type"] = "application/json";
  button.disabled = true;
  try {
    const request = {
      method,
      headers,
      body: data.has("body") ? text("body") : null,
      signal: AbortSignal.timeout(TIMEOUT_MS),
      credentials: /** @type {const} */ ("omit"),
    };
    const response = await fetch(url, request);
    const body = await response.text();
    output.replaceChildren(...shown(response, body));
    if (response.ok) learn(operation, body);
  } catch (error) {
    if (!(error instanceof TypeError) && !(error instanceof DOMException)) throw error;
    output.replaceChildren(
      el(
        "p",
        { class: "problem" },
        error.name === "TimeoutError" ? "No answer within 30 s." : "The service cannot be reached.",
      ),
    );
  } finally {
    button.disabled = false;
  }
}

/** @param {Response} response @param {string} body @returns {Node[]} */
function shown(response, body) {
  const headers = SHOWN_HEADERS.filter((name) => response.headers.has(name)).map(
    (name) => `${name}: ${response.headers.get(name)}`,
  );
  const status = el(
    "p",
    {},
    el("strong", { class: response.ok ? "good" : "problem" }, String(response.status)),
    ` ${headers.join(" · ")}`,
  );
  return body ? [status, el("pre", { tabindex: "0" }, el("code", {}, readable(body)))] : [status];
}

/** @param {string} body */
function readable(body) {
  try {
    return JSON.stringify(JSON.parse(body), null, 2).replace(
      /\[\s+([^[\]{}]*?)\s+\]/g,
      (_, list) => `[${list.replace(/,\s+/g, ", ")}]`,
    );
  } catch (error) {
    if (!(error instanceof SyntaxError)) throw error;
    return body;
  }
}

/** @param {string} operation @param {string} body */
function learn(operation, body) {
  if (
    !["openSession", "lookup", "visitLookup", "searchCameras", "startSession", "finishSession", "createRig"].includes(
      operation,
    )
  )
    return;
  const answer = JSON.parse(body);
  learnt.session = answer.session_id ?? learnt.session;
  learnt.rig = answer.rig_id ?? learnt.rig;
  learnt.id = answer.id ?? answer.calibration_id ?? learnt.id;
  learnt.key = answer.cameras?.[0]?.key ?? learnt.key;
  fillCredentials();
}
