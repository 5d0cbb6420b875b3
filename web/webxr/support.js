// Support for WebXR that the browser has by itself.

/** Is there nothing that can show augmented reality? */
export async function isNeeded() {
  const { xr } = /** @type {any} */ (navigator);
  try {
    return !(await xr?.isSessionSupported("immersive-ar"));
  } catch (error) {
    if (error instanceof DOMException) return true; // forbidden by a policy
    throw error;
  }
}
