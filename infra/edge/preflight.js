// CloudFront function of the API's paths: answers the CORS preflights of browsers at the edge, as functions and the
// gateway would, and passes on everything else.
function handler(event) {
  var request = event.request;
  if (request.method !== "OPTIONS" || !request.headers["access-control-request-method"]) return request;
  return {
    statusCode: 204,
    statusDescription: "No Content",
    headers: {
      "access-control-allow-origin": { value: "*" },
      "access-control-allow-methods": { value: "GET,POST,PATCH,DELETE,OPTIONS" },
      "access-control-allow-headers": { value: "authorization,content-type,accept,if-none-match" },
      "access-control-max-age": { value: "86400" },
      "cache-control": { value: "no-store" },
    },
  };
}
