// A block of code: its colours, and a button that copies it. Blocks of a page's source have one from the start
// (header.js); a block that is made later gets its own by `addCopyButton(pre)`, before or after the page has it.
import { onLanguage, t } from "./i18n.js";

const SHOWN_MS = 2000;

/**
 * @param {HTMLElement} pre with the code; gets a wrapper with the button, unless it has one
 * @returns {HTMLElement} the wrapper
 */
export function addCopyButton(pre) {
  if (pre.parentElement?.classList.contains("code")) return pre.parentElement;
  const wrapper = document.createElement("div");
  wrapper.className = "code";
  const button = document.createElement("button");
  button.type = "button";
  button.className = "copy";
  const said = document.createElement("span");
  said.className = "unseen";
  said.setAttribute("role", "status");
  let outcome = "";
  const show = () => {
    button.textContent = t(outcome || "common.copy");
    said.textContent = outcome && t(outcome);
  };
  let timer = 0;
  button.addEventListener("click", async () => {
    const copied = await copy((pre.textContent ?? "").trimEnd());
    if (!copied) getSelection()?.selectAllChildren(pre);
    outcome = copied ? "common.copied" : "common.selected";
    show();
    clearTimeout(timer);
    timer = setTimeout(() => {
      outcome = "";
      show();
    }, SHOWN_MS);
  });
  onLanguage(show);
  show();
  pre.replaceWith(wrapper);
  wrapper.append(pre, button, said);
  if (!wrapper.closest(".block")) highlightCode(pre);
  return wrapper;
}

/** Copies a text. @param {string} text @returns {Promise<boolean>} false: the browser does not allow it */
export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch (error) {
    // Not a secure context (TypeError: `navigator.clipboard` is missing), or not permitted.
    if (!(error instanceof DOMException) && !(error instanceof TypeError)) throw error;
    return false;
  }
}

const STRING = /(?<string>"[^"\n]*"|(?<!\w)'[^'\n]*'|`[^`\n]*`)/.source;
const COMMENT = /(?<comment>(?<=^|\s)(?:\/\/|#)\s.*)/.source;
const KEYWORDS =
  "import from as const let await async new function return if else for in of def with true false null None True False";
const PARTS = new RegExp(`${STRING}|${COMMENT}|\\b(?<keyword>${KEYWORDS.replaceAll(" ", "|")})\\b`, "gm");

/**
 * Colours strings, comments and keywords of JavaScript, Python and JSON, as the browser's highlights: no element is
 * made for a word.
 * @param {HTMLElement} code
 */
function highlightCode(code) {
  if (!("highlights" in CSS)) return;
  /** @type {{node: Node, end: number}[]} */
  const texts = [];
  const walker = document.createTreeWalker(code, NodeFilter.SHOW_TEXT);
  let end = 0;
  while (walker.nextNode()) {
    end += walker.currentNode.textContent?.length ?? 0;
    texts.push({ node: walker.currentNode, end });
  }
  const place = (/** @type {number} */ offset) => {
    const index = texts.findIndex((text) => offset <= text.end);
    return /** @type {const} */ ([texts[index].node, offset - (texts[index - 1]?.end ?? 0)]);
  };
  for (const match of (code.textContent ?? "").matchAll(PARTS)) {
    const name = Object.entries(match.groups ?? {}).find(([, text]) => text !== undefined)?.[0] ?? "";
    const range = new Range();
    range.setStart(...place(match.index));
    range.setEnd(...place(match.index + match[0].length));
    CSS.highlights.set(name, (CSS.highlights.get(name) ?? new Highlight()).add(range));
  }
}
