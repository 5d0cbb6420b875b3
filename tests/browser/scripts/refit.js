async (key) => {
  const { lookup } = await import("/sdk/calibdb.js");
  const { cameraParameters } = await import("/sdk/adapters/artoolkit.js");
  const options = { token: "cdb_dev_local", cache: null };
  const ask = (model) => lookup(key, { ...options, model });
  const answers = await Promise.all(["rectilinear", "fisheye"].map(ask));
  const [stored, refitted] = answers.map(({ calibration }) => calibration);
  const { url, file, error } = await cameraParameters(stored, options);
  const bytes = (await file.arrayBuffer()).byteLength;
  URL.revokeObjectURL(url);
  const rays = [
    [0, 0, 1],
    [0.3, 0.1, 1],
    [-0.4, 0.25, 1],
    [0.5, -0.28, 1],
  ];
  const apart = rays.map((ray) => {
    const [[u, v], [x, y]] = [stored, refitted].map((each) => each.project(ray));
    return Math.hypot(u - x, v - y);
  });
  return {
    models: answers.map(({ calibration }) => calibration.distortion_model),
    module: refitted.toOpenCV().module,
    coefficients: refitted.distortion_coefficients.length,
    reliable: refitted.reliable,
    apart,
    bytes,
    error,
  };
};
