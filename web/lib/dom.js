// DOM elements: making them and finding them.

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} name
 * @param {Record<string, string | number | boolean | undefined>} [attributes] false and undefined: left out
 * @param {...(Node | string)} content
 * @returns {HTMLElementTagNameMap[K]}
 */
export function el(name, attributes = {}, ...content) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value !== false && value !== undefined) made.setAttribute(key, value === true ? "" : String(value));
  }
  made.append(...content);
  return made;
}

/**
 * @template {Element} E
 * @param {string} id
 * @param {new () => E} type
 * @returns {E} of the page; a page that lacks it says so
 */
export function part(id, type) {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new TypeError(`the page has no ${type.name} #${id}`);
  return found;
}
