async (series) => {
  const { Detector } = await import("/lib/detector.js");
  const { recognise } = await import("/lib/board-recognition.js");
  const { DEFAULT_BOARD } = await import("/lib/board.js");
  const bytes = (data) => Uint8Array.from(atob(data), (character) => character.charCodeAt(0));
  const bitmap = (data) => createImageBitmap(new Blob([bytes(data)]));
  const detector = await Detector.open(DEFAULT_BOARD);
  const outcomes = {};
  for (const [name, pictures] of Object.entries(series)) {
    await detector.change(DEFAULT_BOARD);
    const first = await bitmap(pictures[0]);
    const found = recognise([await detector.sight(first, { families: [], inverted: true, timeout: 120000 })]);
    if (!found) continue;
    await detector.change(found.board);
    const views = [];
    for (const data of pictures) {
      views.push(await detector.detect(await bitmap(data), { full: true, timeout: 120000 }));
    }
    outcomes[name] = { board: found.board, views: views.map(({ ids, points }) => ({ ids, points })) };
  }
  detector.close();
  return outcomes;
};
