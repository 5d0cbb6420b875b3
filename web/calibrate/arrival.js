// Arrival of the visitor, looked at before anything is drawn, so that the page is laid out for it from the start. A
// classic script,
// for it must run before the page.
(() => {
  const query = new URLSearchParams(location.search);
  const { classList } = document.documentElement;
  classList.toggle("sent", query.has("return_to"));
  classList.toggle("asked", query.has("camera"));
  // A phone that was sent here by the screen that shows the board needs no other one.
  classList.toggle("sent-by-screen", query.has("facing"));
  classList.toggle("loopback", /^(localhost|127\.0\.0\.1|\[::1\])$/.test(location.hostname));
})();
