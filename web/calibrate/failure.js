// Why a capture ended: a code that names a text, `capture.fault_<code>`, and what stands in it.
import { explain } from "../faults.js";
import { OfflineError } from "../network.js";
import { SettingsError } from "../settings.js";
import { ApiError } from "./api.js";
import { CameraError } from "./camera.js";
import { DetectorError } from "./detector.js";

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
