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
  let sum = 0;
  const [inA, inB] = [new Float64Array(a.length), new Float64Array(b.length)];
  const heights = [...a, ...b].map((point) => point[1] / OVERLAP_REDUCTION);
  const [top, bottom] = [
    Math.max(0, Math.floor(Math.min(...heights)) - 1),
    Math.min(rows, Math.ceil(Math.max(...heights)) + 1),
  ];
  for (let row = top; row < bottom; row++) {
    const y = (row + 0.5) * OVERLAP_REDUCTION - 0.5;
    const [countA, countB] = [findSpans(a, y, columns, inA), findSpans(b, y, columns, inB)];
    for (let i = 0; i < countA; i += 2) sum += inA[i + 1] - inA[i];
    for (let j = 0; j < countB; j += 2) sum += inB[j + 1] - inB[j];
    for (let i = 0; i < countA; i += 2) {
      for (let j = 0; j < countB; j += 2)
        both += Math.max(0, Math.min(inA[i + 1], inB[j + 1]) - Math.max(inA[i], inB[j]));
    }
  }
  return sum === 0 ? 0 : both / (sum - both);
}

/**
 * The parts of one row inside a polygon, by the even-odd rule.
 * @param {number[][]} polygon @param {number} y px @param {number} columns of the row
 * @param {Float64Array} spans filled: start and end of each part, columns
 * @returns {number} how many numbers were filled in
 */
function findSpans(polygon, y, columns, spans) {
  let count = 0;
  for (let index = 0; index < polygon.length; index++) {
    const from = polygon[index];
    const to = polygon[index + 1 < polygon.length ? index + 1 : 0];
    if (from[1] <= y === to[1] <= y) continue;
    const crossing = from[0] + ((y - from[1]) / (to[1] - from[1])) * (to[0] - from[0]);
    let at = count++;
    for (; at > 0 && spans[at - 1] > crossing; at--) spans[at] = spans[at - 1];
    spans[at] = crossing;
  }
  for (let index = 0; index + 1 < count; index += 2) {
    // Pixel i has its centre at (i + 0.5) * OVERLAP_REDUCTION - 0.5.
    spans[index] = Math.max(0, Math.ceil((spans[index] + 0.5) / OVERLAP_REDUCTION - 0.5));
    spans[index + 1] = Math.max(
      spans[index],
      Math.min(columns, Math.ceil((spans[index + 1] + 0.5) / OVERLAP_REDUCTION - 0.5)),
    );
  }
  return count - (count % 2);
}
