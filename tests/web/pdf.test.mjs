import assert from "node:assert/strict";
import { test } from "node:test";
import { blackRectangles } from "../../web/lib/board-drawing.js";
import { DEFAULT_BOARD } from "../../web/lib/board.js";
import { boardPdf } from "../../web/lib/board-pdf.js";
import { PAPERS, squareSide } from "../../web/lib/papers.js";

const FOOT = { bar: "100 mm", lines: ["9 × 6 Felder (28 mm)", "Eben muß sie sein."] };
const none = () => null;
const latin = (bytes) => Buffer.from(bytes).toString("latin1");

test("squares are whole millimetres, as large as the paper allows", () => {
  assert.equal(squareSide(DEFAULT_BOARD, PAPERS.A4), 28);
  assert.ok(squareSide(DEFAULT_BOARD, PAPERS.A3) > 40);
});

test("the cross-reference table points at the objects", () => {
  const text = latin(boardPdf(DEFAULT_BOARD, PAPERS.A4, FOOT, none));
  const start = Number(/startxref\n(\d+)/.exec(text)[1]);
  assert.equal(text.slice(start, start + 4), "xref");
  const offsets = [...text.slice(start).matchAll(/^(\d{10}) 00000 n /gm)].map(([, offset]) => Number(offset));
  assert.equal(offsets.length, 5);
  offsets.forEach((offset, index) => assert.ok(text.startsWith(`${index + 1} 0 obj`, offset)));
  const stream = /stream\n(.*)\nendstream/s.exec(text)[1];
  assert.equal(Number(/Length (\d+)/.exec(text)[1]), stream.length);
});

test("the page is A4 and the board on it true to scale", () => {
  const text = latin(boardPdf(DEFAULT_BOARD, PAPERS.A4, FOOT, none));
  const [, , width, height] = /MediaBox \[(.*?)\]/.exec(text)[1].split(" ").map(Number);
  assert.ok(Math.abs(width - (297 * 72) / 25.4) < 0.01 && Math.abs(height - (210 * 72) / 25.4) < 0.01);
  const rectangles = [...text.matchAll(/^(.+) re$/gm)].map(([, numbers]) => numbers.split(" ").map(Number));
  const expected = blackRectangles(DEFAULT_BOARD);
  const side = (28 * 72) / 25.4;
  const left = Math.min(...rectangles.slice(0, expected.length).map(([x]) => x));
  const top = Math.max(...rectangles.slice(0, expected.length).map(([, y, , h]) => y + h));
  expected.forEach(([x, y, w, h], index) => {
    const [u, v, a, b] = rectangles[index];
    for (const [is, should] of [
      [u, left + x * side],
      [v + b, top - y * side],
      [a, w * side],
      [b, h * side],
    ]) {
      assert.ok(Math.abs(is - should) < 2e-3, `rectangle ${index}: ${is}, not ${should} points`);
    }
  });
  assert.ok(rectangles.slice(expected.length).some(([, , w]) => Math.abs(w - (100 * 72) / 25.4) < 1e-3));
});

test("captions are letters, or pictures if the font lacks them", () => {
  const text = latin(boardPdf(DEFAULT_BOARD, PAPERS.A4, FOOT, none));
  assert.ok(text.includes("(9 × 6 Felder \\(28 mm\\)) Tj"));
  const picture = { width: 16, height: 2, size: 2, depth: 1, bits: Uint8Array.of(255, 0, 170, 41) };
  const drawn = latin(boardPdf(DEFAULT_BOARD, PAPERS.A4, { bar: "100 мм", lines: ["a", "дошка"] }, () => picture));
  assert.match(drawn, /\/XObject << \/I0 6 0 R \/I1 7 0 R >>/);
  assert.match(drawn, /q 64 0 0 8 \S+ \S+ cm \/I1 Do Q/);
  assert.equal(
    drawn.match(/\/ImageMask true .*\/Width 16 \/Height 2 \/Length 4 >>\nstream\n\xff\x00\xaa\)\nendstream/g).length,
    2,
  );
});
