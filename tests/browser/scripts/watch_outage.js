// Before a page's scripts: what it shows during an outage.
{
  // Requests time out only after two minutes.
  const limit = AbortSignal.timeout.bind(AbortSignal);
  AbortSignal.timeout = (ms) => limit(12 * ms);

  // `seen`: instruction, a full ring, notice; `slowest`: the longest that the page waited, ms; `stood`: whether the
  // notice was there three seconds after a request: timers keep their order, however busy a page is.
  Object.assign(window, { seen: [], slowest: 0, stood: [] });
  // A function that has not run for a while has to start: its first answers take longer.
  const cold = ["pose", "views"];
  const send = window.fetch;
  window.fetch = async (address, request) => {
    const [, kind] = /\/v1\/session\/([a-z]+)/.exec(address) ?? [];
    const headers = new Headers(request?.headers);
    const asked = performance.now();
    headers.set("x-asked", asked);
    setTimeout(() => window.stood.push([asked, !document.getElementById("away").hidden]), 3_000);
    if (cold.includes(kind)) {
      cold.splice(cold.indexOf(kind), 1);
      await new Promise((resolve) => setTimeout(resolve, 3_000));
    }
    try {
      return await send(address, { ...request, headers });
    } finally {
      window.slowest = Math.max(window.slowest, performance.now() - asked);
    }
  };
  document.addEventListener("DOMContentLoaded", () => {
    const ids = ["instruction", "ring", "held", "away"];
    const [instruction, ring, held, away] = ids.map((id) => document.getElementById(id));
    const isFull = () => ring.classList.contains("taken") || held.getAttribute("stroke-dasharray") === "100 100";
    const write = () =>
      window.seen.push([
        performance.now(),
        instruction.textContent,
        !ring.hasAttribute("hidden") && isFull(),
        away.hidden ? "" : away.textContent,
      ]);
    const changes = { subtree: true, childList: true, characterData: true, attributes: true };
    new MutationObserver(write).observe(document.getElementById("stage").parentElement, changes);
  });
}
