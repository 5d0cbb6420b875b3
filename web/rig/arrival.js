// Arrival of the visitor, looked at before anything is drawn, so that the page is laid out for it from the start. A
// classic script,
// for it must run before the page.
(() => {
  const query = new URLSearchParams(location.search);
  const { classList } = document.documentElement;
  classList.toggle("joins", query.has("code") || query.has("join"));
  // A result, or a capture that this browser takes up again: the first sheet would only flash.
  classList.toggle("arrives", query.has("id") || query.get("virtual") === "1");
  classList.toggle("loopback", /^(localhost|127\.0\.0\.1|\[::1\])$/.test(location.hostname));
})();
