async ([asked, png]) => {
  const { Calibration } = await import("/sdk/calibdb.js");
  const { widePinhole } = await import("/sdk/rectification.js");
  const bytes = Uint8Array.from(atob(png), (letter) => letter.charCodeAt(0));
  const blob = new Blob([bytes], { type: "image/png" });
  const made = [];
  for (const [kind, calibration, options] of asked) {
    const warp = await new Calibration(calibration)[kind](options);
    const { img_size: size } = kind === "distorter" ? widePinhole(calibration) : calibration;
    warp.draw(await createImageBitmap(blob, 0, 0, ...size));
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [warp.canvas.width, warp.canvas.height];
    canvas.getContext("2d").drawImage(warp.canvas, 0, 0);
    made.push({ matrix: warp.camera_matrix, size: warp.img_size, png: canvas.toDataURL("image/png") });
    warp.dispose();
  }
  return made;
};
