// Sounds, vibration, speech and the live region, by what happens in a capture.
import { language } from "../lib/i18n.js";
import * as statusText from "./status-text.js";

/** @typedef {import("./state.js").State} State */

/**
 * @param {import("./state.js").Event} event
 * @param {State} state after it
 * @param {State | null} before as the page shows it
 * @param {{feedback: import("../lib/capture/feedback.js").Feedback, announcer:
 *   import("../lib/capture/announcer.js").Announcer}} voices
 */
export function giveFeedback(event, state, before, { feedback, announcer }) {
  if (state.phase === "done" && before?.phase !== "done") feedback.give("done");
  else if (event.type === "stored" || (event.type === "answer" && event.answer.accepted)) feedback.give("taken");
  else if (event.type === "answer") feedback.give("refused");
  if (state.phase !== "capturing") return;
  const hint = statusText.instruction(state);
  const { mismatchWarning, remedy, statusLine, notice } = statusText;
  const news = [mismatchWarning(state), statusLine(state), notice(state.ui.notice)];
  announcer.say([hint, remedy(state)].filter(Boolean).join(". "), ...news);
  feedback.say(hint, language(), performance.now());
}
