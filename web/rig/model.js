// Model of a capture on one device: its cameras, the moment that is open, and all that the page shows.

/**
 * @typedef {import("./service.js").RigState} RigState
 * @typedef {import("./moments.js").Sight} Sight
 *
 * @typedef {object} Member one camera of this device
 * @property {number} position
 * @property {string} session id
 * @property {import("../lib/capture/streams.js").Stream} stream
 * @property {number} half index of its picture in the stream
 * @property {import("./figure.js").Figure} figure
 * @property {[number, number]} size px
 * @property {string} camera label
 *
 * @typedef {object} Current moment that is open, as this device sees it
 * @property {string} id
 * @property {number} unopenedAt ms, when it was certainly not open yet
 * @property {number} seenAt ms, when it was seen to be open
 * @property {Map<number, "take" | "miss">} answers of this device's cameras
 * @property {boolean} over
 *
 * @typedef {object} Model all that the page shows of a capture
 * @property {RigState | null} state
 * @property {Map<number, Sight>} sights by position
 * @property {Current | null} moment
 * @property {boolean} opening a moment is being opened
 * @property {boolean} offline
 * @property {number} waiting views on this device
 * @property {{key: string, kind: "good" | "bad" | "plain", values?: Record<string, string | number>} | null} notice
 * @property {boolean} finishing
 * @property {number} patience ms, for which other devices need the board to be still
 * @property {boolean} stalled the detector has stopped, and is restarted
 *
 * @typedef {object} Resources
 * @property {import("./service.js").RigService} service
 * @property {import("./membership.js").RigRecord} record
 * @property {() => Promise<unknown>} save
 * @property {import("../lib/board.js").SentBoard} board
 * @property {import("../lib/detector.js").Detector} detector
 * @property {() => Promise<import("../lib/detector.js").Detector>} openDetector opens another one after it has failed
 * @property {Member[]} members
 * @property {import("./virtual-rig.js").VirtualRig | null} virtual
 * @property {AbortSignal} signal
 * @property {(model: Model) => void} onChange
 * @property {(sign: import("../lib/capture/feedback.js").Sign) => void} onSign
 * @property {(error: unknown) => void} onFailure
 * @property {(moment: string, position: number, corners: import("../lib/board-outline.js").Corners, picture:
 *   ImageBitmap) => void} onTaken picture: never sent
 */

/** A device was turned: its picture has another size. */
export class ResizeError extends Error {}
