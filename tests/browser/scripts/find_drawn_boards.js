async (dictionaries) => {
  const { Detector } = await import("/lib/detector.js");
  const { raster } = await import("/lib/board-drawing.js");
  const { DEFAULT_BOARD } = await import("/lib/board.js");
  const detector = await Detector.open(DEFAULT_BOARD);
  const found = {};
  for (const dictionary of dictionaries) {
    const board = { squares: [9, 6], marker_ratio: 0.65, dictionary, legacy: false };
    const { width, height, data } = raster(board, 50, 30);
    const context = new OffscreenCanvas(width, height).getContext("2d");
    const picture = context.createImageData(width, height);
    data.forEach((grey, pixel) => picture.data.set([grey, grey, grey, 255], 4 * pixel));
    context.putImageData(picture, 0, 0);
    await detector.change(board);
    const bitmap = context.canvas.transferToImageBitmap();
    const { ids, points } = await detector.detect(bitmap, { full: true, timeout: 120_000 });
    found[dictionary] = ids.map((id, at) => [id, ...points[at]]);
  }
  detector.close();
  return found;
};
