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
