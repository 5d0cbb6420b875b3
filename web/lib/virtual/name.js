// Name of the virtual camera: whoever sees its calibrations can tell that no real camera stands behind them.

export const NAME = "calibDB virtual camera";

/** @param {string} label of a camera */
export const isVirtual = (label) => label.startsWith(NAME);
