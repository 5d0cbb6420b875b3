// Guided capture, in English.

/** @type {Record<string, import("../lib/i18n.js").Text>} */
export default {
  title: "Calibrate a camera · calibDB",
  description: "Hold a board where the outline shows it, and calibDB calibrates the camera.",
  viewfinder: "Viewfinder",
  video: "The camera's picture",
  follow: "Follow the outline",
  sent_lead: "Besides the positions of the corners, only this is sent:",
  sent_label: "What is sent about the camera",
  progress: "Progress of the calibration",

  // Before
  heading: "Calibrate a camera",
  lead:
    "Hold the board where the outline shows it, and keep it still. The page takes views by itself; four or five "
      + "are enough.",
  need_board:
    "Show the <0>calibration board</0> on a second screen or a tablet, or print it and glue it to something rigid.",
  permission:
    "Open the camera. Your browser asks whether this page may use it. <0>Pictures never leave this device.</0>",
  what_is_sent: "What is sent?",
  privacy:
    "The positions of the board's corners; the name that your browser gives the camera; its settings "
      + "(resolution, zoom, focus, frame rate); the operating system that your browser reports; and the requested "
      + "board, lens model and accuracy. Never a picture.",
  resolution: "Resolution",
  largest: "The camera's largest",
  got_size: "The camera delivers {size}, so this page calibrates that size.",
  photos: "Do you have photographs instead?",
  camera: "Camera",
  open: "Open the camera",
  try_virtual: "No webcam? Try the virtual camera",
  virtual: "Try the virtual camera",
  virtual_name: "Virtual camera, for practice",
  camera_number: "Camera {number}",
  no_camera: "No camera found",
  camera_at: "{camera} at {size}",
  asked_for: "Requested: {camera}.",
  not_among: "It is not among the cameras found here.",
  none_here: "No camera was found here. Plug it in.",
  none_at_all: "No camera was found. Plug one in, or practise with the virtual camera.",
  another_opened: "Requested: {asked}. Opened: {opened}. The result will be for the opened camera.",
  interrupted: {
    one:
      "A capture of {camera} was interrupted. Its {count} view is saved on this device. Open the same camera to "
        + "continue.",
    other:
      "A capture of {camera} was interrupted. Its {count} views are saved on this device. Open the same camera "
        + "to continue.",
  },
  go_on: "Continue",
  forget: "Discard it",

  // While getting ready
  getting_ready: "Getting ready",
  opening_camera: "Waiting for the camera. If your browser asks, allow it.",
  opening_loading: "Loading the board detector, 12 MB the first time.",
  opening_starting: "Starting the board detector.",
  opening_service: "Opening a session at calibDB.",
  opening_retry: "The connection to calibDB is lost. Trying again.",
  loading: "Loading the board detector",
  cancel: "Cancel",

  // The one instruction: six words at most
  say_show: "Show the board to the camera",
  say_slower: "Closer, or a little slower",
  say_more: "Show more of the board",
  say_wait: "One moment",
  say_enough: "Enough views. Waiting for calibDB",
  say_away: "Waiting for calibDB",
  say_retry: "Connection lost. Trying again",
  say_stalled: "Restarting the board detector",
  say_hold: "Hold still",
  say_match: "Match the outline",
  say_first: "Match the outline",
  say_left: "Move left",
  say_right: "Move right",
  say_up: "Move up",
  say_down: "Move down",
  say_up_left: "Move up and left",
  say_up_right: "Move up and right",
  say_down_left: "Move down and left",
  say_down_right: "Move down and right",
  say_closer: "Closer to the camera",
  say_farther: "Farther from the camera",
  say_tilt_top: "Top edge closer",
  say_tilt_bottom: "Bottom edge closer",
  say_tilt_left: "Left edge closer",
  say_tilt_right: "Right edge closer",
  say_turn_clockwise: "Turn to the right",
  say_turn_counterclockwise: "Turn to the left",
  say_dark: "Too dark",
  say_bright: "Too bright",
  say_blurred: "Blurred",
  say_far: "Too far away",
  say_wrong_board: "This is another board",
  say_legacy: "This board has the older layout",
  say_mirrored: "The picture is mirrored",
  say_moire: "Stripes in the picture",
  say_moving: "Move more slowly",

  // What to do about it
  do_show: "No board yet? “Board” at the top opens one, for another screen or for printing.",
  do_dark: "Turn on a light, or turn the board towards the window.",
  do_bright: "Turn the board away from the light, or turn down the brightness of its screen.",
  do_blurred: "Hold it still and a little farther away; wipe the lens; let the camera focus.",
  do_far: "The squares are too small to measure. Come closer.",
  do_wrong_board:
    "Its markers belong to another board than the requested one. Open the right board from the link above.",
  do_legacy:
    "It was made for OpenCV before 4.6. The page switches to that layout by itself; you can also print a new "
      + "board.",
  do_mirrored: "Turn off mirroring in the camera's own settings or software.",
  do_moire:
    "Move a little closer or farther away, or turn down the brightness of the board's screen: its pixels "
      + "interfere with the camera's.",
  do_moving: "The camera reads the picture line by line, so a fast movement distorts it.",

  // What became of a view
  view_taken: "View {number} taken.",
  view_stored: "View saved. It will be sent once calibDB is back.",
  view_undone: "The last view was undone.",
  undo_away: "You can undo the last view only once calibDB is back.",
  view_set_aside: "View {number} does not fit the others and was left out.",
  refused: "That view was not taken.",
  refused_too_few_points: "Too little of the board was visible.",
  refused_degenerate: "That view alone is not enough. Tilt the board.",
  refused_mirrored: "The picture is mirrored. Turn that off in the camera's settings.",
  refused_outlier: "That view did not fit the others. Is the board flat?",
  refused_no_information: "That view adds nothing new. Follow the outline.",
  useless: "Looking for a better pose.",
  press_again: {
    one: "Press again to stop and lose {count} view.",
    other: "Press again to stop and lose {count} views.",
  },
  came_back_only: "calibDB is back.",
  sending: "calibDB is back. The saved views are being sent.",
  came_back: "calibDB is back. All views were sent.",
  came_back_less: {
    one: "calibDB is back. {count} view added nothing new.",
    other: "calibDB is back. {count} views added nothing new.",
  },
  away_now: "No connection. Continue: views are saved on this device.",
  away_enough: "No connection. Enough views are saved on this device and will be sent once calibDB is back.",
  begun_anew: "The session had expired. A new session has your views.",
  was_hidden: "No views were taken while this page was hidden. You can continue.",
  not_kept: "This browser cannot save views. Do not close the page.",
  resized:
    "The picture has another size now, so this is a separate calibration. Turn the device back to continue the "
      + "first one.",
  legacy_taken: "The board has the older layout. The page uses that layout now.",
  advice_prediction_disagrees: "The views do not agree as well as they should. calibDB needs a few more.",
  advice_model_too_simple: "This model is too simple for the lens. “{model}” would fit better.",
  advice_board_bent: "The board is not flat. Glue it to something rigid, such as glass or a tray.",
  advice_motion: "The board or the camera moves while views are taken. Hold it still for longer.",
  advice_focus_changed: "The focus changes between views. Switch autofocus off.",
  advice_limit_reached: "The capture has reached its limit of 15 views.",

  // The rim
  views: { one: "{count} view", other: "{count} views" },
  set_aside: { one: "{count} left out", other: "{count} left out" },
  waiting_views: { one: "{count} waiting", other: "{count} waiting" },
  kept_of: "{count} of {wanted} saved here",
  with_model: "Start again with “{model}”",
  zoom: "zoom {zoom}",
  cropped: "cropped by the browser",
  undo: "Undo",
  skip: "Another pose",
  stop: "Stop",
  stop_really: "Stop?",
  reached: "± {reached}, goal {goal} px",
  senses: "Signals",
  sound: "Sound",
  vibration: "Vibration",
  voice: "Spoken hints",

  // When something fails
  failed: "That did not work",
  again: "Try again",
  other: "Choose another camera",
  kept: {
    one: "{count} view is saved. Try again with the same camera to continue.",
    other: "{count} views are saved. Try again with the same camera to continue.",
  },
  fault_not_allowed:
    "The browser was not allowed to use the camera. Allow it in the address bar or in the system settings, then "
      + "try again.",
  fault_not_found: "No camera was found. Plug one in, or try the virtual camera.",
  fault_in_use: "Another program is using the camera. Close it, then try again.",
  fault_too_strict: "The camera cannot deliver this resolution. Choose another camera.",
  fault_interrupted: "The camera did not start. Close other programs that may be using it, then try again.",
  fault_no_picture:
    "The camera is open but sends no picture. Unplug it and plug it in again, or close other programs that may "
      + "be using it.",
  fault_insecure: "Browsers let only secure pages use cameras. Open this page over HTTPS or on localhost.",
  fault_elsewhere: "This camera is being calibrated in another tab. Continue there, or close that tab and try again.",
  fault_gone: "This camera is no longer connected. Plug it in, or choose another camera.",
  fault_not_opened: "The camera could not be opened ({detail}).",
  fault_unplugged: "The camera was unplugged. Plug it in again, and this page continues by itself.",
  fault_resized: "The picture's size changed.",
  fault_offline: "calibDB cannot be reached. Check the connection and try again.",
  fault_settings: "The page's settings are missing. Try again later.",
  fault_service: "{detail}",
  fault_detector: "The board detector failed ({detail}). Try again.",
  fault_detector_missing: "The board detector is missing. Try again later.",
  fault_detector_lost: "The board detector could not be loaded. Check the connection and try again.",
  fault_detector_silent: "The board detector does not answer. Reload the page.",
  fault_unforeseen: "Something went wrong in this page ({detail}).",

  // The result
  practice: "This was practice with a simulated camera. Its calibration is not of a real camera.",
  once_more: "Calibrate again",
};
