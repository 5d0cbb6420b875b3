// An application as three.js' own examples are: of the camera, its lens and this project it knows nothing.
const application = async (points) => {
  const { Mesh, MeshBasicMaterial, PerspectiveCamera, Scene, SphereGeometry, WebGLRenderer } =
    await import("/three/three.module.js");
  const { ARButton } = await import("/three/ARButton.js");
  const renderer = new WebGLRenderer({ antialias: true, alpha: true });
  renderer.setSize(window.innerWidth / 2, window.innerHeight);
  renderer.xr.enabled = true;
  document.body.append(renderer.domElement, ARButton.createButton(renderer));
  const scene = new Scene();
  for (const [x, y, z] of points) {
    const ball = new Mesh(new SphereGeometry(0.02), new MeshBasicMaterial({ color: 0xff0000 }));
    ball.position.set(x, -y, -z); // where we say x right, y down, z forward
    scene.add(ball);
  }
  const camera = new PerspectiveCamera(70, window.innerWidth / window.innerHeight, 0.01, 20);
  renderer.setAnimationLoop(() => renderer.render(scene, camera));
  return renderer;
};

const run = async () => {
  // The page's owner knows of calibDB.
  const { useCamera } = await import("/webxr/camera.js");
  const { video } = await webcam([640, 360], label, (context) => {
    context.fillStyle = "#00ff00";
    for (const [x, y] of marks) {
      context.beginPath();
      context.arc(x + 0.5, y + 0.5, 6, 0, 7);
      context.fill();
    }
    context.fillStyle = "#000000";
  });
  await new Promise((onAnswer) => useCamera(video, { token: "cdb_dev_local", rectify: true, onAnswer }));
  const renderer = await application(points);
  const button = document.getElementById("ARButton");
  while (button.textContent !== "START AR") await new Promise(requestAnimationFrame);
  const begun = new Promise((done) => renderer.xr.addEventListener("sessionstart", done));
  window.over = new Promise((done) => renderer.xr.addEventListener("sessionend", done));
  button.click();
  await begun;
  for (let frame = 0; frame < 10; frame++) {
    await new Promise((done) => renderer.xr.getSession().requestAnimationFrame(done));
  }
};
