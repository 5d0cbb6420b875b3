// Membership of this device's cameras in a rig: their sessions, and the record of them that this browser keeps.
import { ApiError } from "../lib/api.js";
import { consentFields } from "../lib/consent.js";

/**
 * @import { SentBoard } from "../lib/board.js"
 * @import { Choice, Picture } from "../lib/capture/streams.js"
 * @import { RigService, SessionRequest } from "./service.js"
 */

/**
 * @typedef {object} SavedMember one camera of this device
 * @property {number} position
 * @property {string} session id, its credential; "" until there is one
 * @property {boolean} opened the service has answered that the session is part of the rig
 * @property {SessionRequest | null} request as it was sent
 *
 * @typedef {object} RigRecord all that is needed to continue with a rig after the page was lost
 * @property {string} about id of the rig
 * @property {boolean} leads this device leads
 * @property {string} query of the page's address
 * @property {number} cameras of the rig, in all
 * @property {number | null} square_size metres
 * @property {Choice[]} choices of this device's cameras
 * @property {SavedMember[]} members in the order of the choices' pictures
 * @property {import("./outbox.js").Letter[]} letters captured, and not yet delivered
 *
 * @typedef {object} Board
 * @property {SentBoard} board
 */

/** The service refuses a field of what this device sends. */
export class JoinError extends Error {
  /** @param {string} code names a text: `rig.join_<code>` @param {ApiError} error */
  constructor(code, error) {
    super(error.message);
    this.code = code;
  }
}

/**
 * Body of POST /v1/session for one picture.
 * @param {Picture} picture
 * @param {SentBoard} board
 * @param {Choice} choice
 * @returns {SessionRequest}
 */
export const requestOf = ({ camera, platform, size, zoom, track }, board, { distortion_model }) => ({
  camera,
  platform,
  img_size: size,
  zoom,
  board,
  distortion_model,
  track,
});

/**
 * Makes this device's cameras members of a rig: its first camera begins the rig, or joins with a code. It
 * completes what a lost page has begun.
 * @param {RigService} service @param {RigRecord} record completed in place
 * @param {SessionRequest[]} requests of the cameras, in the record's order
 * @param {{code?: string, save: () => Promise<unknown>}} options code: of the rig to join
 * @returns {Promise<{code: string, expires: number} | null>} the fresh code of a rig that is led; expires: ms since
 *   1970
 */
export async function enter(service, record, requests, { code, save }) {
  /** @type {{code: string, expires: number} | null} */
  let invitation = null;
  for (const [index, member] of record.members.entries()) {
    if (member.opened) continue;
    // The same request again: the service returns the same session.
    member.request ??= { ...requests[index], ...consentFields() };
    member.session ||= await service.authenticate();
    if (record.about) await save();
    if (index === 0 && record.leads) {
      await service.openSession(member.session, member.request);
      invitation = await invite(service, record);
    } else {
      const rig = record.about ? { id: record.about } : { code: code ?? "" };
      const asked = member.position > 0 ? { position: member.position } : {};
      const state = await service
        .openSession(member.session, { ...member.request, rig: { ...rig, ...asked } })
        .catch(refuse);
      if (!state.rig) throw new TypeError("the service has not made this session part of the rig");
      record.about = state.rig.id;
      member.position = state.rig.position;
    }
    member.opened = true;
    await save();
  }
  return invitation;
}

/** A code for the rig, which the first call makes. @param {RigService} service @param {RigRecord} record */
export async function invite(service, record) {
  const {
    cameras,
    square_size,
    members: [{ session }],
  } = record;
  const made = await service.create(session, { cameras, ...(square_size && { square_size }) });
  record.about = made.rig_id;
  return { code: made.join_code, expires: 1000 * made.expires_at };
}

/** @param {unknown} error @returns {never} */
function refuse(error) {
  if (!(error instanceof ApiError)) throw error;
  const field = ["rig.code", "rig.position", "rig.id", "board"].find((name) => error.message.includes(`${name}:`));
  if (error.status === 422 && field) throw new JoinError(field.replace("rig.", ""), error);
  if (error.status === 429) throw new JoinError("attempts", error);
  throw error;
}
