// Before the body of a function that runs in a page: the GPU is lost, and what is drawn is read back.

/** Takes a context away; the result gives it back. What is drawn meanwhile is nothing. */
const lose = async (canvas) => {
  const extension = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
  const lost = new Promise((done) => canvas.addEventListener("webglcontextlost", done, { once: true }));
  extension.loseContext();
  await lost;
  await new Promise((done) => setTimeout(done)); // whether it may come back is decided once all have heard
  return () =>
    new Promise((done) => {
      canvas.addEventListener("webglcontextrestored", done, { once: true });
      extension.restoreContext();
    });
};

const read = (canvas) => {
  const { width, height } = canvas;
  const copy = new OffscreenCanvas(width, height).getContext("2d");
  copy.drawImage(canvas, 0, 0);
  return copy.getImageData(0, 0, width, height).data;
};

/** The sum of what a Rectifier and a Distorter draw, before, while and after the GPU was lost. */
const sumsOfWarps = async (calibration) => {
  const { Calibration } = await import("/sdk/calibdb.js");
  const sums = [];
  for (const kind of ["rectifier", "distorter"]) {
    const warp = await new Calibration(calibration)[kind]();
    const picture = new OffscreenCanvas(...(kind === "rectifier" ? calibration.img_size : warp.img_size));
    const paint = picture.getContext("2d");
    for (let x = 0; x < picture.width; x += 40) {
      paint.fillStyle = `hsl(${x} 80% 50%)`;
      paint.fillRect(x, 0, 40, picture.height);
    }
    const sum = () => {
      warp.draw(picture);
      return read(warp.canvas).reduce((all, value) => all + value, 0);
    };
    const before = sum();
    const giveBack = await lose(warp.canvas);
    const meanwhile = sum();
    await giveBack();
    sums.push({ before, meanwhile, after: sum() });
    warp.dispose();
  }
  return sums;
};

const layer = () => document.getElementById("layers").lastChild;

/** How many pixels of the AR page's drawing are seen, in the task in which they were drawn. */
const countSeen = () =>
  new Promise((done) => {
    const observer = new MutationObserver(() => {
      observer.disconnect();
      done(read(layer()).filter((value, at) => at % 4 === 3 && value > 0).length);
    });
    observer.observe(document.getElementById("stage"), { attributes: true, attributeFilter: ["data-shown"] });
  });

/** Those pixels in each mode of the page, before and after the GPU was lost. */
const countsOfOverlays = async () => {
  const counts = [];
  for (const button of document.querySelectorAll("#modes button")) {
    button.click();
    const before = await countSeen();
    const giveBack = await lose(layer());
    await giveBack();
    let after = await countSeen();
    for (let frame = 0; frame < 20 && after === 0; frame++) after = await countSeen();
    counts.push({ mode: button.value, before, after });
  }
  return counts;
};
