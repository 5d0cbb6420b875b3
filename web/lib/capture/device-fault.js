// Texts about a camera or a board detector that failed.
import { CameraError } from "../camera.js";
import { DetectorError } from "../detector.js";
import { t } from "../i18n.js";

/**
 * Code of a message `capture.fault_<code>`, and what the browser says.
 * @param {unknown} error @returns {{code: string, detail: string} | null} null: another error
 */
export function deviceFault(error) {
  if (error instanceof CameraError) return { code: error.code, detail: error.detail };
  if (error instanceof DetectorError) return { code: error.code, detail: error.message };
  return null;
}

/** @param {unknown} error @returns {string} "" for another error */
export function deviceFaultText(error) {
  const fault = deviceFault(error);
  return fault ? t(`capture.fault_${fault.code}`, { detail: fault.detail }) : "";
}
