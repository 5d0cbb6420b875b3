// Code to copy, with the address of this service and a token filled in.

/** @typedef {{origin: string, token: string}} Values */

/** Languages of the snippets, in the order in which they are offered. */
export const SNIPPETS = /** @type {const} */ (["page", "curl"]);

/** @type {Record<typeof SNIPPETS[number], (values: Values) => string>} */
const WRITERS = {
  page: ({ origin, token }) => `<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>Calibration of my camera</title>
<pre id="answer">Opening the camera…</pre>
<button id="calibrate" hidden>Calibrate this camera</button>
<script type="module">
  import { calibrate, lookup, returned } from "${origin}/sdk/calibdb.js";

  const token = "${token}";
  const [answer, button] = [document.querySelector("#answer"), document.querySelector("#calibrate")];

  async function main() {
    const stream = await navigator.mediaDevices.getUserMedia({ video: true });
    const [track] = stream.getVideoTracks();
    const found = await lookup(track, { token });
    const calibration = found.calibration ?? (await returned({ token })); // known, or just measured
    if (calibration) {
      answer.textContent = JSON.stringify(calibration, null, 2); // camera_matrix, distortion_coefficients, …
    } else {
      answer.textContent = \`calibDB does not know \${track.label} yet.\`;
      button.hidden = false;
      button.onclick = () => calibrate({ token, source: track, returnTo: location.href }); // and back to this page
    }
  }
  main().catch((error) => { answer.textContent = error.message; });
</script>
`,
  curl: ({ origin, token }) => `curl -s ${origin}/v1/lookup \\
  -H "Authorization: Bearer ${token}" -H "Content-Type: application/json" \\
  -d '{"camera": "HD Pro Webcam C920 (046d:082d)", "platform": "X11; Linux x86_64",
       "img_size": [1280, 720], "miss": "ok"}'
`,
};

/** @param {typeof SNIPPETS[number]} kind @param {Values} values */
export const snippet = (kind, values) => WRITERS[kind](values);
