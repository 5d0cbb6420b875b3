async ([calibration, rate]) => {
  const { Rectifier } = await import("/sdk/rectifier.js");
  const source = document.createElement("canvas");
  [source.width, source.height] = calibration.img_size;
  const paint = source.getContext("2d", { alpha: false });
  document.body.append(source);
  let frame = 0;
  const painter = setInterval(() => {
    paint.fillStyle = `hsl(${frame++ * 7} 80% 50%)`;
    paint.fillRect((frame * 13) % 1200, (frame * 29) % 600, 80, 120);
  }, 1000 / rate);
  const video = document.createElement("video");
  video.muted = true;
  video.srcObject = source.captureStream(30);
  await video.play();
  const rectifier = new Rectifier(calibration, { scale: 0.5 });
  const gl = rectifier.canvas.getContext("webgl2");
  const [shown, spent] = [[], []];
  await new Promise((done) => {
    const next = (now, { presentedFrames }) => {
      const start = performance.now();
      rectifier.draw(video);
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // until it is drawn
      spent.push(performance.now() - start);
      shown.push(presentedFrames);
      if (shown.length < 30) video.requestVideoFrameCallback(next);
      else done();
    };
    video.requestVideoFrameCallback(next);
  });
  clearInterval(painter);
  source.remove();
  rectifier.dispose();
  const dropped = shown.at(-1) - shown[0] + 1 - shown.length;
  return { dropped, median: spent.sort((a, b) => a - b)[spent.length >> 1] };
};
