// Looks a camera up and opens a session, then requests what needs one: without a board the service refuses.
async ([service, token]) => {
  const { lookup } = await import(`${service}/sdk/calibdb.js`);
  const camera = { camera: "Elsewhere (1234:0009)", platform: "X11; Linux x86_64", img_size: [1280, 720], zoom: 0 };
  const { reason } = await lookup(camera, { token, cache: null });
  const ask = (method, path, bearer, body) =>
    fetch(`${service}/v1/${path}`, {
      method,
      headers: { authorization: `Bearer ${bearer}`, "content-type": "application/json" },
      body,
    });
  const opened = await ask("POST", "auth", token);
  const { session_id } = await opened.json();
  const answers = await Promise.all([
    ask("POST", "session", session_id, "{}"),
    ask("GET", "session/pose", session_id),
    ask("POST", "session/views", session_id, "{}"),
  ]);
  return [reason, opened.status, answers.map(({ status }) => status)];
};
