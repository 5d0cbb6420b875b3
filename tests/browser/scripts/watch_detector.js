async (frames) => {
  const { DEFAULT_BOARD, corners } = await import("/lib/board.js");
  const { Painter } = await import("/lib/virtual/painter.js");
  const { projectionOf } = await import("/lib/virtual/lens.js");
  const { transformPoint } = await import("/lib/pose.js");
  const { Detector } = await import("/lib/detector.js");
  const size = [1280, 720];
  const lens = { fx: 1000, fy: 1000, cx: 664.5, cy: 359.5, k1: -0.25, k2: 0, p1: 0, p2: 0, k3: 0 };
  const pose = { rvec: [0.35, -0.45, 0.1], tvec: [-4, -3, 9] };
  const picture = new ImageData(...size);
  new Painter(DEFAULT_BOARD, lens, size).paint(pose, picture.data);
  const projection = projectionOf(lens);
  const truth = corners(DEFAULT_BOARD).map(([x, y]) => projection.project(transformPoint(pose, [x, y, 0])));

  const progress = [];
  const detector = await Detector.open(DEFAULT_BOARD, (part) => progress.push(part));
  const patient = { timeout: 120_000 };
  const one = async (full, image = picture) => detector.detect(await createImageBitmap(image), { full, ...patient });
  const full = await one(true);
  const memory = [];
  const elapsed = [];
  for (let index = 0; index < frames; index++) {
    const seen = await one(false);
    memory.push(seen.memory);
    elapsed.push(seen.elapsed);
  }
  const empty = await one(false, new ImageData(...size));
  detector.close();
  return { truth, full, progress, memory, elapsed, empty };
};
