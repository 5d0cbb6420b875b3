// Sessions of WebXR as tests hold them; put behind webxr.js.
const sessions = {
  async changing() {
    const { useCamera } = await import("/webxr/camera.js");
    const { video, track, resize } = await webcam([1280, 720], label);
    const answers = [];
    const onAnswer = ({ calibration, reason }) => answers.push(reason ?? calibration.img_size);
    let silent = false;
    const send = (...request) => (silent ? new Promise(() => {}) : fetch(...request));
    const stop = await useCamera(video, { token: "cdb_dev_local", cache: null, fetch: send, onAnswer });
    const session = await navigator.xr.requestSession("immersive-ar", { optionalFeatures: ["local-floor"] });
    await layered(session);
    const space = await session.requestReferenceSpace("local-floor");
    const seen = [await until(session, space, (view) => view.distortionModel)];
    for (const [size, known] of [
      [[720, 1280], false],
      [[1280, 720], true],
    ]) {
      resize(...size);
      track.dispatchEvent(new Event("configurationchange"));
      seen.push(await until(session, space, (view) => (view.distortionModel !== null) === known));
      while (answers.length < seen.length) await new Promise(requestAnimationFrame);
    }
    // From the frame on in which the video shows another picture, while the question is open.
    silent = true;
    resize(720, 1280);
    const open = await until(session, space, () => video.videoWidth === 720);
    stop();
    await session.end();
    return { seen, answers, open };
  },
  async immersive() {
    const { extend } = await import("/webxr/extension.js");
    const { install, isNeeded } = await import("/webxr/install.js");
    const needed = await isNeeded();
    const { video } = await webcam();
    let calibration = null;
    install({ video, pinhole: () => calibration });
    const again = extend(async (_, model) => calibration && known[model]);
    const supported = await navigator.xr.isSessionSupported("immersive-ar");
    const session = await navigator.xr.requestSession("immersive-ar");
    const twice = await navigator.xr.requestSession("immersive-ar").catch(({ name }) => name);
    const canvas = await layered(session);
    const space = await session.requestReferenceSpace("local");
    const none = await until(session, space, () => true);
    calibration = known.rectilinear;
    await again();
    const first = await until(session, space, (view) => view.distortionModel === "rectilinear");
    session.updateRenderState({ distortionModel: "fisheye" });
    const second = await until(session, space, (view) => view.distortionModel === "fisheye");
    const over = canvas.parentNode === video.parentNode && canvas.parentNode !== document.body;
    const { width, height } = canvas.getBoundingClientRect();
    const ended = new Promise((done) => session.addEventListener("end", done));
    window.dispatchEvent(new KeyboardEvent("keydown", { key: "Escape" }));
    await ended;
    const back = video.parentNode === document.body && !canvas.getAttribute("style");
    return { needed, supported, twice, none, first, second, over, back, window: [width, height] };
  },
};
