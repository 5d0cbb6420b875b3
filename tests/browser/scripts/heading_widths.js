// Widths of the heading as it is, and in a typeface of the same file under another name, px
async () => {
  const heading = [...document.querySelectorAll("h1")].find((each) => each.checkVisibility());
  const range = document.createRange();
  range.selectNodeContents(heading);
  const width = () => range.getBoundingClientRect().width;
  const shown = width();
  const face = new FontFace("Truth", "url(/vendor/font/geologica-latin.woff2)", { weight: "1 1000" });
  document.fonts.add(await face.load());
  heading.style.fontFamily = "Truth";
  const expected = width();
  heading.style.fontFamily = "monospace";
  return [shown, expected, width()];
};
