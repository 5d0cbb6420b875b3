// What the page shows in each of its ways, read back from its canvases, once the board has come to rest.
async () => {
  const stage = document.getElementById("stage");
  const layers = document.getElementById("layers");
  const shown = () =>
    new Promise((done) => {
      const observer = new MutationObserver(() => {
        observer.disconnect();
        done();
      });
      observer.observe(stage, { attributes: true, attributeFilter: ["data-shown"] });
    });
  // In the task in which it was drawn: a moment later the browser has taken what WebGL drew.
  const read = (canvas) => {
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [canvas.width, canvas.height];
    copy.getContext("2d").drawImage(canvas, 0, 0);
    const { x, y, width, height } = canvas.getBoundingClientRect();
    return { png: copy.toDataURL("image/png"), place: [x, y, width, height] };
  };
  const look = () => ({
    picture: read(layers.firstChild),
    overlay: read(layers.lastChild),
    said: document.querySelector(".off").textContent,
  });
  const pixels = ({ width, height }) => {
    const copy = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
    copy.drawImage(layers.firstChild, 0, 0);
    return new BigUint64Array(copy.getImageData(0, 0, width, height).data.buffer);
  };
  await shown();
  for (let before = new BigUint64Array(), alike = 0; alike < 8;) {
    await shown();
    const now = pixels(layers.firstChild);
    alike = now.length === before.length && now.every((value, at) => value === before[at]) ? alike + 1 : 0;
    before = now;
  }
  const balance = document.getElementById("balance");
  const seen = {};
  for (const button of document.querySelectorAll("#modes button:not([value=estimate])")) {
    button.click();
    seen[button.value] = look();
    if (balance.checkVisibility()) {
      balance.value = "1";
      balance.dispatchEvent(new Event("input"));
      seen.whole = look();
    }
  }
  return seen;
};
