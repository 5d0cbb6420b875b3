// Redirect before anything is drawn: it leads readers of German or Ukrainian from a page's English address to the page
// in that language.
//
// An address with a language ("/de/board/") decides; one without is English unless "?lang=", the language chosen
// before, or the browser's own says otherwise. A classic script, for it must run before the page.
(() => {
  const script = /** @type {HTMLScriptElement} */ (document.currentScript);
  const base = new URL("./", script.src).pathname;
  const path = location.pathname.slice(base.length);
  const here = /^(de|uk)\//.exec(path)?.[1] ?? "en";
  const query = new URLSearchParams(location.search);
  /** @param {string | null | undefined} tag */
  const languageOf = (tag) => /^(en|de|uk)\b/i.exec(tag ?? "")?.[1].toLowerCase();
  /** The language chosen before; a browser that blocks storage throws on access. */
  const kept = () => {
    try {
      return languageOf(localStorage.getItem("calibdb.language"));
    } catch {
      return undefined;
    }
  };
  const inQuery = languageOf(query.get("lang"));
  const wanted =
    inQuery ?? (here === "en" ? (kept() ?? navigator.languages.map(languageOf).find(Boolean) ?? "en") : here);
  if (wanted === here) return;
  const rest = here === "en" ? path : path.slice(3);
  if (wanted !== "en") query.delete("lang");
  const search = query.toString();
  location.replace(`${base}${wanted === "en" ? "" : `${wanted}/`}${rest}${search && `?${search}`}${location.hash}`);
  // Until the other page loads, this page neither shows nor runs: its rest becomes text of a hidden element.
  document.write("<plaintext hidden>");
})();
