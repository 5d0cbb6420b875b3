// Latest run of a task: a new run aborts the one before, whose result is dropped.

/**
 * @template {unknown[]} A @template T
 * @typedef {((...parameters: A) => Promise<T | undefined>) & {cancel: () => void}} Latest cancel: aborts the current
 *   run
 */

/**
 * Makes a function of which only the latest call counts. An earlier call is aborted: whatever it returns or throws
 * after that is dropped, and its promise resolves to undefined. In the task, `signal.throwIfAborted()` after an
 * `await` ends it.
 * @template {unknown[]} A @template T
 * @param {(signal: AbortSignal, ...parameters: A) => Promise<T>} task
 * @returns {Latest<A, T>}
 */
export function latest(task) {
  let controller = new AbortController();
  const run = async (/** @type {A} */ ...parameters) => {
    controller.abort();
    const { signal } = (controller = new AbortController());
    try {
      const result = await task(signal, ...parameters);
      return signal.aborted ? undefined : result;
    } catch (error) {
      if (!signal.aborted) throw error;
    }
  };
  return Object.assign(run, { cancel: () => controller.abort() });
}
