async (faults) => {
  const { DEFAULT_BOARD } = await import("/lib/board.js");
  const { Painter } = await import("/lib/virtual/painter.js");
  const { degrade } = await import("/lib/virtual/degrade.js");
  const { Detector } = await import("/lib/detector.js");
  const { HEALTHY, diagnose, nextProbe } = await import("/lib/capture/diagnosis.js");
  const size = [1280, 720];
  const lens = { fx: 1000, fy: 1000, cx: 664.5, cy: 359.5, k1: -0.25, k2: 0, p1: 0, p2: 0, k3: 0 };
  const detector = await Detector.open(DEFAULT_BOARD);
  const painters = new Map();
  const painterOf = (board) => {
    const name = JSON.stringify(board);
    if (!painters.has(name)) painters.set(name, new Painter({ ...DEFAULT_BOARD, ...board }, lens, size));
    return painters.get(name);
  };
  const said = {};
  for (const [name, { fault, board = {}, z = 9 }] of Object.entries(faults)) {
    const picture = new ImageData(...size);
    const pose = { rvec: [0.35, -0.45, 0.1], tvec: [-4, -3, z] };
    painterOf(board).paint(pose, picture.data);
    if (fault) degrade(picture, fault);
    const found = new Map(); // of one picture, for the same question, it is always the same
    let state = HEALTHY;
    for (let time = 1000; time < 16000 && !state.trouble; time += 250) {
      const probe = nextProbe(state, time);
      if (!found.has(probe)) {
        const frame = await createImageBitmap(picture);
        found.set(probe, await detector.detect(frame, { probe, timeout: 120_000 }));
      }
      state = diagnose(state, found.get(probe), 0, time);
    }
    said[name] = state.trouble;
  }
  detector.close();
  return said;
};
