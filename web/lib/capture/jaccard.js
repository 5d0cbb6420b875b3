// Jaccard index of two areas of the image: |A ∩ B| / |A ∪ B|, counted in pixels of a quarter of the size.

const OVERLAP_REDUCTION = 4; // |ΔJ| < 0.01 against full size

/**
 * @param {number[][]} a polygon, px @param {number[][]} b polygon, px
 * @param {[number, number]} size of the image: what lies outside does not count
 * @returns {number} 0…1; 0 where both are empty
 */
export function jaccard(a, b, [width, height]) {
  const columns = Math.ceil(width / OVERLAP_REDUCTION);
  const rows = Math.ceil(height / OVERLAP_REDUCTION);
  let both = 0;
  let either = 0;
  const [inA, inB] = [new Uint8Array(columns), new Uint8Array(columns)];
  const heights = [...a, ...b].map((point) => point[1] / OVERLAP_REDUCTION);
  const [top, bottom] = [Math.max(0, Math.floor(Math.min(...heights)) - 1), Math.min(rows, Math.ceil(Math.max(...heights)) + 1)];
  for (let row = top; row < bottom; row++) {
    const y = (row + 0.5) * OVERLAP_REDUCTION - 0.5;
    fillRow(a, y, inA);
    fillRow(b, y, inB);
    for (let column = 0; column < columns; column++) {
      both += inA[column] & inB[column];
      either += inA[column] | inB[column];
    }
  }
  return either === 0 ? 0 : both / either;
}

/** The part of one row inside a polygon, by the even-odd rule. @param {number[][]} polygon @param {number} y @param {Uint8Array} row */
function fillRow(polygon, y, row) {
  row.fill(0);
  /** @type {number[]} */
  const crossings = [];
  polygon.forEach(([x1, y1], index) => {
    const [x2, y2] = polygon[(index + 1) % polygon.length];
    if (y1 <= y !== y2 <= y) crossings.push(x1 + ((y - y1) / (y2 - y1)) * (x2 - x1));
  });
  crossings.sort((left, right) => left - right);
  for (let index = 0; index + 1 < crossings.length; index += 2) {
    // Pixel i has its centre at (i + 0.5) * OVERLAP_REDUCTION - 0.5.
    const start = Math.max(0, Math.ceil((crossings[index] + 0.5) / OVERLAP_REDUCTION - 0.5));
    const end = Math.min(row.length, Math.ceil((crossings[index + 1] + 0.5) / OVERLAP_REDUCTION - 0.5));
    if (start < end) row.fill(1, start, end);
  }
}
