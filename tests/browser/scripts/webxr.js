// What tests of WebXR share; put before the body of a function that runs in a page.

// calibrations of one camera under two models, as a lookup would give them
const known = {
  rectilinear: {
    img_size: [640, 360],
    camera_matrix: [
      [500, 0, 325],
      [0, 505, 178],
      [0, 0, 1],
    ],
    distortion_model: "rectilinear",
    distortion_coefficients: [-0.25, 0.0625, 0, 0, 0],
  },
  fisheye: {
    img_size: [640, 360],
    camera_matrix: [
      [490, 0, 324],
      [0, 495, 177],
      [0, 0, 1],
    ],
    distortion_model: "fisheye",
    distortion_coefficients: [-0.125, 0.5, 0, 0.25],
  },
};

const look = (view) => ({
  matrix: view.cameraMatrix && [...view.cameraMatrix],
  model: view.distortionModel,
  coefficients: view.distortionCoefficients && [...view.distortionCoefficients],
});

/** What the first frame says for which a condition on its view holds. */
const until = (session, space, holds) =>
  new Promise((resolve, reject) => {
    const end = performance.now() + 100_000; // ms
    const next = (now, frame) => {
      const views = frame.getViewerPose(space)?.views ?? [];
      const [view] = views;
      if (view && holds(view)) resolve({ ...look(view), views: views.length, p: [...view.projectionMatrix] });
      else if (performance.now() > end) reject(new Error("no such frame: " + JSON.stringify(views.map(look))));
      else session.requestAnimationFrame(next);
    };
    session.requestAnimationFrame(next);
  });

/** A canvas that a session draws into. */
const layered = async (session, width = 640, height = 360) => {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  document.body.append(canvas);
  const gl = canvas.getContext("webgl2");
  session.updateRenderState({ baseLayer: new XRWebGLLayer(session, gl) });
  return canvas;
};

/** A camera made of a canvas: `paint` draws its picture, `resize` changes it as turning a phone does. */
const webcam = async ([width, height] = [640, 360], label = "Nobody's camera (0000:0001)", paint = () => {}) => {
  const source = document.createElement("canvas");
  const context = source.getContext("2d");
  document.body.append(source);
  const resize = (w, h) => ([source.width, source.height] = [w, h]);
  resize(width, height);
  setInterval(() => {
    context.fillRect(0, 0, source.width, source.height);
    paint(context);
  }, 100);
  const stream = source.captureStream(10);
  const [track] = stream.getVideoTracks();
  Object.defineProperty(track, "label", { value: label });
  track.getSettings = () => ({ width: source.width, height: source.height, resizeMode: "none" });
  const video = document.createElement("video");
  video.muted = true;
  video.srcObject = stream;
  document.body.append(video);
  await video.play();
  return { video, track, resize };
};
