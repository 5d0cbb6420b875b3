// Texts of the capture: the one instruction, a line below it, and what is said of each camera.
import { isThere, movement } from "../lib/capture/sight.js";
import { hasMessage, number, t } from "../lib/i18n.js";
import { splitLabel, isVirtual } from "../lib/camera-name.js";
import { isSeen, requiredHold } from "./moments.js";
import { MIN_VIEWS, isAlone, remotePositions, silentPositions } from "./progress.js";

/**
 * @import { Member, Model } from "./capture.js"
 * @import { Sight } from "./moments.js"
 * @import { Moment, RigState } from "./service.js"
 */

const SHOWN_ELSEWHERE = new Set(["waiting", "converged"]); // in the list of cameras, by the end
const RIG_ADVICE = new Set(["unlinked", "no_fit", "contradicts", "set_aside", "turned", "too_few_views"]);

/** Name of a camera: people count from 1. @param {number} position */
export const cameraName = (position) => t("rig.camera", { number: position + 1 });

/** @param {readonly number[]} positions */
export function cameraNames(positions) {
  const names = positions.map((position) => String(position + 1));
  return t("rig.cameras_listed", {
    count: names.length,
    numbers: new Intl.ListFormat(document.documentElement.lang || "en").format(names),
  });
}

/** @param {string | null} label */
export const labelText = (label) => (!label ? "" : isVirtual(label) ? t("rig.simulated") : splitLabel(label).name);

/**
 * Code of the instruction: a message `rig.say_<code>`, or `capture.say_<code>`.
 * @param {Model} model @param {readonly Member[]} members @param {boolean} leads
 */
export function instruct({ state, moment, opening, offline, finishing, sights, patience, stalled }, members, leads) {
  if (stalled) return "stalled";
  if (finishing) return "finishing";
  if (!state) return offline ? "away" : "wait";
  if (opening || (moment && !moment.over)) return "hold";
  if (leads && isAlone(state)) return "join";
  const remote =
    remotePositions(
      state,
      members.map(({ position }) => position),
    ).length > 0;
  if (offline && remote) return "away";
  const seeing = members
    .map((member) => ({ member, sight: /** @type {Sight} */ (sights.get(member.position)) }))
    .filter(({ sight }) => sight && isSeen(sight));
  if (seeing.length === 0) return unseen(state, [...sights.values()], members, leads);
  if (
    seeing.some(({ sight }) => sight.target && isThere(sight)) &&
    requiredHold(
      seeing.map(({ sight }) => sight),
      patience,
    ) !== null
  )
    return "hold";
  const aimed = seeing
    .filter(({ sight }) => sight.aim && sight.outline)
    .sort((a, b) => a.sight.distance - b.sight.distance)[0];
  if (!aimed)
    return seeing.some(({ sight }) => sight.target) || !state.target ? "match" : leads ? "elsewhere" : "follow";
  return movement(aimed.sight, aimed.member.stream.mirrored);
}

/** @param {RigState} state @param {Sight[]} sights @param {readonly Member[]} members @param {boolean} leads */
function unseen({ target }, sights, members, leads) {
  const here = target?.cameras.some(({ position }) => members.some((member) => member.position === position));
  if (target && !here) return leads ? "elsewhere" : "follow";
  return sights.find(({ diagnosis }) => diagnosis.trouble)?.diagnosis.trouble ?? "show";
}

/** @param {string} code @param {Model} model */
export function instruction(code, { state }) {
  const first = state?.target?.cameras[0]?.position ?? 0;
  const key = hasMessage(`rig.say_${code}`) ? `rig.say_${code}` : `capture.say_${code}`;
  return t(key, { camera: cameraName(first) });
}

/**
 * Line below the instruction.
 * @param {Model} model
 * @param {readonly Member[]} members
 * @param {boolean} leads
 * @param {string} code of the instruction
 */
export function detail({ state, moment, notice, offline, waiting, opening }, members, leads, code) {
  const own = members.map(({ position }) => position);
  const remote = state ? remotePositions(state, own) : [];
  if (offline) return waiting > 0 ? t("rig.kept", { count: waiting }) : t("rig.no_connection");
  if (state && leads && (opening || (moment && !moment.over))) {
    const there = state.moments.find(({ id }) => id === moment?.id)?.positions ?? [];
    const missing = remote.filter((position) => !there.includes(position));
    if (missing.length > 0) return t("rig.waiting_for", { cameras: cameraNames(missing) });
  }
  // “Move on” would contradict an order to hold still.
  if (notice && !(code === "hold" && notice.kind === "good")) return t(notice.key, notice.values);
  if (!state) return "";
  const silent = silentPositions(state, own);
  if (leads && silent.length > 0) return t("rig.silent", { cameras: cameraNames(silent) });
  if (code === "join") return t("rig.do_join");
  if (state.unlinked.length > 0) return t("rig.link", { cameras: cameraNames([0, ...state.unlinked]) });
  if (hasMessage(`capture.do_${code}`)) return t(`capture.do_${code}`);
  return leads || code === "hold" ? "" : t("rig.follower");
}

/** Moments so far, and the accuracy. @param {RigState | null} state */
export function counts(state) {
  if (!state) return "";
  const moments = t("rig.moments_count", { count: state.moments.length });
  const { uncertainty, target_error: goal } = state;
  if (!uncertainty) return moments;
  return `${moments} · ${t("rig.reached", { reached: number(uncertainty.rms, 2), goal: number(goal, 2) })}`;
}

/** One camera of the rig, in a list. @param {RigState} state @param {number} position @param {readonly number[]} own */
export function memberLine(state, position, own) {
  const { camera, img_size, status, views } = state.cameras[position];
  if (status === "waiting") return { name: cameraName(position), text: t("rig.waiting_to_join") };
  const what = [labelText(camera), img_size?.join("\u00a0×\u00a0"), own.includes(position) ? "" : t("rig.other_device")]
    .filter(Boolean)
    .join(" · ");
  return { name: cameraName(position), text: `${what} · ${t("rig.views_of", { count: views, needed: MIN_VIEWS })}` };
}

/**
 * Sentences that the rig's state calls for: the service's own only where the page has none, for they are English.
 * @param {RigState} state
 * @returns {string[]}
 */
export const adviceTexts = ({ advice: found }) =>
  found
    .filter(({ code }) => !SHOWN_ELSEWHERE.has(code))
    .map(({ code, text, positions = [] }) =>
      RIG_ADVICE.has(code)
        ? t(`rig.advice_${code}`, { cameras: cameraNames(positions), count: positions.length })
        : text,
    );

/**
 * Reasons for which views of a moment were set aside.
 * @param {Moment} moment
 * @returns {string[]}
 */
export const asideTexts = ({ set_aside: aside = [] }) =>
  aside.map(({ position, reason, detail: said }) =>
    hasMessage(`rig.aside_${reason}`)
      ? t(`rig.aside_${reason}`, { camera: cameraName(position) })
      : `${cameraName(position)}: ${said}`,
  );
