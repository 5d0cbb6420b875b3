// The privacy notice: words, who runs the service, and the receipts of this browser's calibrations.
import { el, part } from "../lib/dom.js";
import { language, onLanguage, t } from "../lib/i18n.js";
import { showOperator } from "../lib/operator.js";
import { openPage } from "../lib/page.js";
import { receipts, removeReceipts } from "../lib/receipts.js";

const MAX_LETTER_RECEIPTS = 5; // mail programs cut longer addresses

openPage();
const [list, none, actions] = [
  part("receipts", HTMLElement),
  part("no-receipts", HTMLElement),
  part("receipt-actions", HTMLElement),
];
const write = part("write", HTMLAnchorElement);
let contact = "";

/** @param {import("../lib/receipts.js").Receipt} receipt */
function item({ id, camera, time, receipt }) {
  const made = new Date(time).toLocaleDateString(language(), { dateStyle: "medium" });
  const page = el("a", { href: `../result/?id=${encodeURIComponent(id)}` }, camera || id);
  return el(
    "li",
    {},
    page,
    ` · ${made}`,
    el(
      "details",
      {},
      el("summary", {}, t("privacy.receipt", { receipt: "" }).trim()),
      el("code", { class: "receipt" }, receipt),
    ),
  );
}

function show() {
  const kept = receipts();
  list.replaceChildren(...kept.map(item));
  none.hidden = kept.length > 0;
  actions.hidden = kept.length === 0;
  write.hidden = contact === "";
  if (!contact.startsWith("mailto:")) {
    write.href = contact;
    return;
  }
  const body = [t("privacy.letter"), "", ...kept.slice(0, MAX_LETTER_RECEIPTS).map(({ receipt }) => receipt)].join(
    "\n",
  );
  write.href = `${contact}?subject=${encodeURIComponent(t("privacy.letter_subject"))}&body=${encodeURIComponent(body)}`;
}

show();
onLanguage(show);
part("remove", HTMLButtonElement).addEventListener("click", () => {
  removeReceipts();
  show();
});
contact =
  (await showOperator({ name: "privacy.name", contact: "privacy.contact", imprint: "privacy.imprint_name" })).contact ??
  "";
show();
