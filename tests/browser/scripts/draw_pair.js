async ([{ left, right, pose }, png, packing]) => {
  const { Rig, rectifyPair } = await import("/sdk/calibdb.js");
  const blob = new Blob([Uint8Array.from(atob(png), (each) => each.charCodeAt(0))], { type: "image/png" });
  const [width, height] = left.img_size;
  const part = (x, y) => createImageBitmap(blob, x, y, width, height);
  const whole = await createImageBitmap(blob);
  const still = { position: 0, rvec: [0, 0, 0], tvec: [0, 0, 0] };
  const rig = new Rig({ calibrations: [left, right], extrinsics: [still, { position: 1, ...pose }] });
  const sources = packing ? [whole, whole] : [await part(0, 0), await part(width, 0)];
  const pair = await rectifyPair(...sources, rig, { packing, scale: 0.5 });
  const shown = [pair.left, pair.right].map((drawn) => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [drawn.width, drawn.height];
    canvas.getContext("2d").drawImage(drawn, 0, 0);
    return { png: canvas.toDataURL("image/png") };
  });
  const [eye] = pair.views();
  const found = { shown, matrix: pair.camera_matrix, point: pair.point([350, 150], 6), eye: eye.eye };
  const video = document.createElement("video");
  found.early = pair.draw(video, video);
  pair.dispose();
  return found;
};
