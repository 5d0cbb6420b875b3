// Arrival of the visitor at a page that captures, looked at before anything is drawn, so that the page is laid out for
// it from the start. A classic script, for it must run before the page.
(() => {
  const query = new URLSearchParams(location.search);
  const { classList } = document.documentElement;
  classList.toggle("loopback", /^(localhost|127\.0\.0\.1|\[::1\])$/.test(location.hostname));
  classList.toggle("sent", query.has("return_to"));
  // A phone that was sent here by the screen that shows the board needs no other one.
  classList.toggle("sent-by-screen", query.has("facing"));
  classList.toggle("joins", query.has("code") || query.has("join"));
  // A result of a rig, or a capture of one that this browser takes up again: the first sheet would only flash.
  classList.toggle("arrives", query.has("id") || query.get("virtual") === "1");
})();
