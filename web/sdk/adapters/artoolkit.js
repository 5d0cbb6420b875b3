// `camera_para.dat` for AR.js and whatever else has ARToolKit in it.
//
//     const { url } = await cameraParameters(calibration, { token });
//     // its page's policy must let it: script-src 'unsafe-eval' 'wasm-unsafe-eval'; connect-src blob:
//     new THREEx.ArToolkitContext({ cameraParametersUrl: url, canvasWidth: width, canvasHeight: height, … });
//     // once it is there: what it draws with is ARToolKit's own matrix, half a pixel off; ours is
//     applyCalibration(camera, calibration, { viewport }); // of ./three.js
import { ask, refusal } from "../request.js";

/**
 * The file, made by the service: of the stored parameters where ARToolKit's model holds them, else of the closest ones
 * that it does.
 * @param {{id: string | null}} calibration as a lookup answered it; one that lies between two zooms has no file
 * @param {import("../request.js").RequestOptions} manner
 * @returns {Promise<{url: string, file: Blob, error: number}>} `error`: px, largest distance between the two over the
 *   image;
 *   `URL.revokeObjectURL(url)` frees it. Rejects as `lookup` does
 */
export async function cameraParameters({ id }, manner) {
  if (!id) throw new TypeError("this calibration was computed for you alone: the service has no file of it");
  const { response, body } = await ask(`calibrations/${encodeURIComponent(id)}?format=artoolkit`, {}, manner);
  const error = response.headers.get("x-conversion-error");
  if (!response.ok || error === null) throw refusal(response, body);
  const file = await response.blob();
  return { url: URL.createObjectURL(file), file, error: Number(error) };
}
