// CloudFront function of the site's pages: maps a folder to its index.html, which S3 origins do not.
// `infra.deploy.package` fills in PAGES, the folders that hold a page, and NOT_FOUND.
var PAGES = [];
// The content of web/404.html.
var NOT_FOUND = "";

function handler(event) {
  var request = event.request;
  // One leading slash: `//host/` in a Location names another host.
  var path = "/" + request.uri.replace(/^[\/\\]+/, "");
  request.uri = path;
  if (path.split("/").pop().includes(".") && !path.endsWith(".html")) return request;
  if (path.endsWith("/index.html")) path = path.slice(0, -"index.html".length);
  var folder = path.endsWith("/") ? path : path + "/";
  if (PAGES.length && !PAGES.includes(folder)) {
    return {
      statusCode: 404,
      statusDescription: "Not Found",
      headers: {
        "content-type": { value: "text/html; charset=utf-8" },
        "cache-control": { value: "no-store" },
        "content-security-policy": {
          value: "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'; object-src 'none'",
        },
        "cross-origin-opener-policy": { value: "same-origin" },
        "strict-transport-security": { value: "max-age=31536000" },
        "x-content-type-options": { value: "nosniff" },
      },
      body: NOT_FOUND,
    };
  }
  if (folder === path) {
    request.uri = path + "index.html";
    return request;
  }
  return {
    statusCode: 301,
    statusDescription: "Moved Permanently",
    headers: { location: { value: folder + query(request.querystring) } },
  };
}

function query(fields) {
  var parts = [];
  for (var name in fields || {}) {
    var values = fields[name].multiValue || [fields[name]];
    values.forEach((one) => parts.push(one.value === "" ? name : name + "=" + one.value));
  }
  return parts.length ? "?" + parts.join("&") : "";
}
