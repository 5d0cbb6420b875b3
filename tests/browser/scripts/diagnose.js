async (faults) => {
  const { DEFAULT_BOARD } = await import("/lib/board.js");
  const { Painter } = await import("/lib/virtual/painter.js");
  const { degrade } = await import("/lib/virtual/degrade.js");
  const { Detector } = await import("/lib/detector.js");
  const { BoardWatch } = await import("/lib/capture/board-watch.js");
  const { BLIND, doubt, observeFrame } = await import("/lib/capture/sight.js");
  const size = [1280, 720];
  const lens = { fx: 1000, fy: 1000, cx: 664.5, cy: 359.5, k1: -0.25, k2: 0, p1: 0, p2: 0, k3: 0 };
  const detector = await Detector.open(DEFAULT_BOARD);
  const painters = new Map();
  const painterOf = (board) => {
    const name = JSON.stringify(board);
    if (!painters.has(name)) painters.set(name, new Painter({ ...DEFAULT_BOARD, ...board }, lens, size));
    return painters.get(name);
  };
  const painted = new Map();
  const pictureOf = (board, z) => {
    const name = JSON.stringify([board, z]);
    if (!painted.has(name)) {
      painted.set(name, new Uint8ClampedArray(4 * size[0] * size[1]));
      painterOf(board).paint({ rvec: [0.35, -0.45, 0.1], tvec: [-4, -3, z] }, painted.get(name));
    }
    return new ImageData(painted.get(name).slice(), ...size);
  };
  const said = {};
  for (const [name, { fault, board = {}, z = 9 }] of Object.entries(faults)) {
    const picture = pictureOf(board, z);
    if (fault) degrade(picture, fault);
    // The same of one picture at any time
    const found = await detector.detect(await createImageBitmap(picture), { timeout: 120_000 });
    let sighting;
    const watch = new BoardWatch();
    let sight = BLIND;
    for (let time = 1000; time < 16000 && !sight.diagnosis.trouble; time += 250) {
      sight = observeFrame(sight, found, time, DEFAULT_BOARD);
      if (!watch.isDue(sight.diagnosis.blindSince, time)) continue;
      sighting ??= await detector.sight(await createImageBitmap(picture), { timeout: 120_000 });
      sight = doubt(sight, watch.add(sighting, DEFAULT_BOARD, time), DEFAULT_BOARD, time);
    }
    said[name] = sight.diagnosis.trouble;
  }
  detector.close();
  return said;
};
