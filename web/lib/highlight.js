// Colours of code in a page, as the browser's highlights: no element is made for a word.

const PARTS =
  /(?<string>"[^"\n]*"|(?<!\w)'[^'\n]*'|`[^`\n]*`)|(?<comment>(?<=^|\s)(?:\/\/|#)\s.*)|\b(?<keyword>import|from|as|const|let|await|async|new|function|return|if|else|for|in|of|def|with|true|false|null|None|True|False)\b/gm;

/** Colours strings, comments and keywords of JavaScript, Python and JSON. @param {HTMLElement} code */
export function highlightCode(code) {
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
