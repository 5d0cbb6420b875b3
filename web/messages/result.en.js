// Result page, in English.

/** @type {Record<string, import("../lib/i18n.js").Text>} */
export default {
  title: "A calibration · calibDB",
  description: "One calibration: how good it is, its numbers, and the pictures behind them.",
  loading: "Fetching the calibration.",
  heading: "A calibration",
  no_id: "The address contains no calibration id.",
  level_good: "Good",
  level_fair: "Fair",
  level_poor: "Poor",
  means_good: "You can rely on it.",
  means_fair: "You can use it, but it could be better.",
  means_poor: "Do not rely on it.",
  sentence: "The expected error is {rms} px on average over the picture, and {max} px at the worst place.",
  reason_too_few_views: "With so few views, they could agree by chance. Take more.",
  reason_no_tilt: "The board was hardly tilted, so the focal length is a guess. Tilt the board more.",
  reason_edges_not_covered: "The board was hardly near the edges of the picture. Move it there.",
  reason_uncertain: "The views do not determine the lens well enough. Take more, from different sides.",
  reason_over_fitted: "The calibration explains test views much worse than the views in the fit. Take more views.",
  reason_model_too_simple:
    "All views have the same pattern of errors: either this model is too simple for the lens, or the board is "
      + "not flat. Choose the {models} model, or glue the board to something rigid.",
  reason_choose_model: "The lens bends more than this model can follow. Choose the {model} model.",
  reason_board_bent: "The board is not flat. Glue it to something rigid, such as glass or a tray.",
  reason_motion: "The board or the camera moved while pictures were taken. Hold it still for longer.",
  reason_focus_changed: "The focus changed between the views. Switch autofocus off.",
  reason_board_not_flat: "The board is bent, or was printed out of shape. That was taken into account. Glue it to something rigid.",
  reason_noisy:
    "The corners are imprecise because of blur, motion, or a board that is not flat. Use more light, and hold "
      + "still.",
  reason_outliers: "Many corners contradict the others and were left out.",
  reason_views_left_out: "Whole views contradict the others and were left out. They are marked below.",
  reason_limit_reached: "Fifteen views were not enough to reach the target error.",
  reason_prediction_disagrees: "The error turned out larger than predicted.",
  part_numbers: "Numbers",
  part_error: "Expected error",
  part_distortion: "Lens distortion",
  part_coverage: "Coverage",
  part_views: "Views",
  part_straight: "Before and after",
  part_take: "Download",
  part_help: "Your contribution",
  intrinsics: "Camera matrix and distortion, {model}",
  quality: "Quality",
  reprojection: "Reprojection error, all corners including those left out",
  held_out: "Error in test views that were not in the fit",
  uncertainty: "Expected error over the picture",
  spread: "Spread of the agreeing calibrations",
  across: "Field of view, side to side",
  down: "Field of view, top to bottom",
  diagonal: "Field of view, corner to corner",
  error_label: "Expected error over the picture: {mean} px on average, {max} px at most",
  error_caption:
    "Expected error of a point, by its position in the picture: {mean} px on average, {max} px at most. "
      + "Stronger colour means a larger error.",
  distortion_label: "Distortion of the lens: up to {max} px",
  distortion_caption:
    "Each line leads from where a lens without distortion would show a point to where this lens shows it: up to "
      + "{max} px. The cross is the principal point.",
  magnified: "Drawn {factor} times larger.",
  coverage_label: "The corners cover {share} % of the picture",
  coverage_caption: "All {count} measured corners. They cover {share} % of the picture.",
  views_text:
    "Each line is a residual: it leads from a measured corner to where the calibration expects it, and is drawn "
      + "{factor} times longer. Short and random is good.",
  view: "View {index}",
  view_label: "Residuals of view {index}: {rms} px",
  view_left_out: "Left out: it contradicts the others. Take it again.",
  view_stands_out: "Much worse than the others. Take it again.",
  view_some_cut: { one: "{count} corner left out, marked ×.", other: "{count} corners left out, marked ×." },
  practice: "This was a practice run with a simulated camera.",
  worth: { one: "Take view {views} again if you can.", other: "Take views {views} again if you can." },
  leave_these: { one: "Show the result without this view", other: "Show the result without them" },
  leave_out: "Leave out",
  take_back: "Put back",
  fitting_without: "Fitting the remaining views.",
  without: {
    one: "The result without view {views}. Only you can see it.",
    other: "The result without views {views}. Only you can see it.",
  },
  without_now: {
    one:
      "Without view {views} the expected error is {after} px; with it, {before} px. The focal length fx is {fx} "
        + "px; with it, {was} px.",
    other:
      "Without views {views} the expected error is {after} px; with them, {before} px. The focal length fx is "
        + "{fx} px; with them, {was} px.",
  },
  without_impossible: "Without views {views} too little is left for a calibration.",
  go_on_without: { one: "Continue without it", other: "Continue without them" },
  go_on_text: "The other views are kept. If they are not enough, the page asks for new ones.",
  all_again: "Back to all views",
  calibrate_again: "Calibrate this camera again",
  before: "As the camera sees it",
  after: "Straightened",
  slider: "How much of the picture is straightened",
  keep_edges: "Keep the whole picture, with black edges",
  no_webgl: "This browser cannot show this because it has no WebGL.",
  trial: "Try it",
  trial_text:
    "Choose a picture that this camera took at this resolution, and see it straightened. It stays on your device.",
  picture: "A picture",
  picture_shape: "That picture has another aspect ratio: this calibration is for {size}.",
  picture_unreadable: "This browser cannot read that picture.",
  format: "Format",
  download: "Download",
  address: "This result has a page of its own",
  as_answered: "As the API returns it",
  as_json: "The calibration as JSON",
  back: "Use it in {host}",
  back_text: "{host} asked for this calibration. It receives the calibration's id, and nothing else.",
  back_refused: "{host} asked for this calibration, but this service does not hand results to that application.",
  help_added:
    "You have added the positions of the corners, your camera's name and settings, and the system that your "
      + "browser names. Not one picture left this device. Once five calibrations of this camera agree, every web "
      + "page can look it up.",
  missing: "There is no such calibration.",
  search: "Search all cameras",
  calibrate: "Calibrate a camera",
  help_photographs:
    "You have added the positions of the corners, the size of the pictures, whether they are photographs or a "
      + "video, and what you said of the camera, its lens and its focal length. Not one picture left this device. "
      + "Once five calibrations of this camera agree, every web page can look it up.",
  help_imported:
    "You have added the positions of the corners, the size of the pictures, your camera's name, and the system "
      + "that your browser names. The file has not left this device. Once five calibrations of this camera agree, "
      + "every web page can look it up.",
  help_practice: "This was a practice run with a simulated camera. Your own camera is not calibrated yet.",
  help_stored: {
    one: "{count} calibration stands behind this. Once five of one camera agree, every web page can look it up.",
    other: "{count} calibrations stand behind this. Once five of one camera agree, every web page can look it up.",
  },
};
