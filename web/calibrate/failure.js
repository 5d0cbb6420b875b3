// Failure of a capture: a code that names a message, `capture.fault_<code>`, and the message's detail.
import { explain } from "../lib/faults.js";
import { OfflineError } from "../lib/network.js";
import { SettingsError } from "../lib/settings.js";
import { ApiError } from "../lib/api.js";
import { CameraError } from "../lib/camera.js";
import { DetectorError } from "../lib/detector.js";

/** @param {unknown} error @returns {{code: string, detail: string}} */
export function failureOf(error) {
  const detail = error instanceof Error ? error.message : String(error);
  if (error instanceof CameraError) return { code: error.code, detail: error.detail };
  if (error instanceof DetectorError) return { code: error.code, detail };
  if (error instanceof OfflineError) return { code: "offline", detail };
  if (error instanceof SettingsError) return { code: "settings", detail };
  if (error instanceof ApiError) return { code: "service", detail: explain(error) };
  console.error(error);
  return { code: "unforeseen", detail };
}
