// Screen that stays on while a device takes part: nobody touches it meanwhile.

/** @param {AbortSignal} signal lets it go off again */
export async function keepAwake(signal) {
  /** @type {WakeLockSentinel | null} */
  let lock = null;
  const ask = async () => {
    if (document.hidden || signal.aborted || !navigator.wakeLock) return;
    try {
      lock = await navigator.wakeLock.request("screen");
      if (signal.aborted) await lock.release();
    } catch (error) {
      if (!(error instanceof DOMException)) throw error; // refused, as with a low battery
    }
  };
  // A hidden page loses it.
  document.addEventListener("visibilitychange", ask, { signal });
  signal.addEventListener("abort", () => void lock?.release());
  await ask();
}
