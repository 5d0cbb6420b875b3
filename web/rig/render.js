// Rendering of a capture into the page. Reads nothing back, decides nothing.
import { drawQr } from "../lib/qr.js";
import { button, el, write } from "../lib/dom.js";
import { settled } from "../lib/capture/target.js";
import { t } from "../lib/i18n.js";
import { holdProgress } from "./moments.js";
import { freePositions, isFinishable } from "./progress.js";
import * as text from "./status-text.js";

/**
 * @import { Member, Model } from "./capture.js"
 * @import { Parts } from "./parts.js"
 * @import { RigState } from "./service.js"
 */

/**
 * @typedef {{code: string, address: string, expires: number} | null} Invitation expires: ms since 1970
 *
 * @typedef {import("../lib/capture/target.js").Instruction & {state: RigState | null,
 *   invitation: Invitation, language: string}} Shown
 */

/** @type {Shown} */
export const NOTHING_SHOWN = { code: "", next: "", since: 0, state: null, invitation: null, language: "" };

/**
 * @param {Parts} parts @param {Model} model
 * @param {{members: readonly Member[], leads: boolean, board: import("../lib/board.js").Board, invitation:
 *   Invitation, time: number, undo: (id: string) => void}} page time: ms; undo: called for a moment
 * @param {Shown} before @returns {Shown & {said: string, line: string}}
 */
export function render(parts, model, { members, leads, board, invitation, time, undo }, before) {
  const { state, sights, waiting } = model;
  const own = members.map(({ position }) => position);
  const wanted = text.instruct(model, members, leads);
  // What one must do at once is said at once, and what is done need not be done any more.
  const urgent = wanted === "hold" || (before.code === "hold" && model.moment?.over === true);
  const instruction = settled(before, wanted, time, urgent);
  const { code } = instruction;
  const said = text.instruction(code, model);
  const line = text.detail(model, members, leads, code);
  write(parts.instruction, said);
  write(parts.detail, line);
  parts.detail.classList.toggle("bad", model.notice?.kind === "bad" && !model.offline);
  for (const { position, figure, camera } of members) {
    const sight = sights.get(position);
    if (sight) figure.render(sight, board, caption(position, camera, sight, state));
  }
  renderRing(parts, model);
  for (const button of parts.leads) button.hidden = !leads;
  parts.finish.hidden = !leads || !state || !isFinishable(state);
  parts.finish.disabled = model.finishing;
  parts.undo.disabled = !state || (state.moments.length === 0 && waiting === 0);
  parts.take.disabled = model.opening || (model.moment !== null && !model.moment.over);
  const { lang } = document.documentElement;
  if (state !== before.state || lang !== before.language) renderState(parts, state, own, leads, undo);
  if (invitation !== before.invitation || state !== before.state || lang !== before.language)
    renderInvitation(parts, state, invitation, leads);
  return { ...instruction, state, invitation, language: lang, said, line };
}

/**
 * @param {number} position
 * @param {string} camera
 * @param {import("./moments.js").Sight} sight
 * @param {RigState | null} state
 */
function caption(position, camera, sight, state) {
  const seen = sight.corners.ids.length > 0;
  const aimed = !state?.target || sight.target !== null || state.unlinked.length > 0;
  const words = seen ? t("rig.sees_board") : aimed ? t("rig.sees_nothing") : t("rig.need_not_see");
  return `${text.cameraName(position)} · ${text.labelText(camera)} · ${words}`;
}

/** @param {Parts} parts @param {Model} model */
function renderRing({ ring, held }, { sights, moment, opening, patience }) {
  const open = opening || (moment !== null && !moment.over);
  const share = open ? 100 : Math.round(100 * holdProgress([...sights.values()], patience));
  held.setAttribute("stroke-dasharray", `${share} 100`);
  ring.classList.toggle("taken", !open && moment !== null && share === 0);
}

/**
 * @param {Parts} parts
 * @param {RigState | null} state
 * @param {readonly number[]} own
 * @param {boolean} leads
 * @param {(id: string) => void} undo
 */
function renderState({ progress, counts, members, advice, moments, momentList }, state, own, leads, undo) {
  if (!state) return;
  progress.value = state.progress;
  write(counts, text.counts(state));
  members.replaceChildren(
    ...state.cameras.map(({ position, status }) => {
      const { name, text: words } = text.memberLine(state, position, own);
      return el("li", { class: status }, el("strong", {}, name), " ", el("span", {}, words));
    }),
  );
  advice.replaceChildren(...text.adviceTexts(state).map((words) => el("li", {}, words)));
  moments.hidden = state.moments.length === 0;
  momentList.replaceChildren(
    ...state.moments
      .map((moment, index) => {
        const words = [
          t("rig.moment_line", {
            number: index + 1,
            cameras: moment.positions.length > 0 ? text.cameraNames(moment.positions) : "…",
          }),
          ...text.asideTexts(moment),
        ];
        const label = t("rig.undo_moment", { number: index + 1 });
        return el(
          "li",
          { class: moment.set_aside?.length ? "aside" : "" },
          el("span", {}, words.join(" ")),
          leads && button(t("rig.undo"), () => undo(moment.id), { "aria-label": label }),
        );
      })
      .reverse(),
  );
}

/**
 * @param {Parts} parts
 * @param {RigState | null} state
 * @param {Invitation} invitation
 * @param {boolean} leads
 */
function renderInvitation({ joining, qr, joinAddress, joinCode, joinUntil }, state, invitation, leads) {
  joining.hidden = !leads || !invitation || (state !== null && freePositions(state).length === 0);
  if (joining.hidden || !invitation) return;
  const { code, address, expires } = invitation;
  if (joinCode.textContent !== code) drawQr(qr, address);
  // To be typed: the code has a field of its own there.
  const { host, pathname, searchParams } = new URL(address);
  searchParams.delete("code");
  write(joinAddress, `${host}${pathname}?join${searchParams.size > 0 ? `&${searchParams}` : ""}`);
  write(joinCode, code);
  const until = new Date(expires).toLocaleTimeString(document.documentElement.lang, {
    hour: "2-digit",
    minute: "2-digit",
  });
  write(joinUntil, t("rig.code_until", { time: until }));
}
