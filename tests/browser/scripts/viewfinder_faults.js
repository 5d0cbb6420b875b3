// What leaves the window, is cut off, or lies over something else.
() => {
  const width = document.documentElement.clientWidth;
  const there = [...document.querySelectorAll(".rim :is(a, button, summary, select, output), .reticle p")]
    .filter((each) => each.checkVisibility() && !each.closest(".unseen, details:not([open]) > :not(summary)"))
    .map((each) => [each.id || each.textContent.trim(), each.getBoundingClientRect(), each]);
  const outside = there.filter(([, box]) => box.left < 0 || box.right > width || box.bottom > innerHeight);
  const cut = there.filter(([, , each]) => each.tagName === "BUTTON" && each.scrollWidth > each.clientWidth);
  const over = there.flatMap(([name, a], at) =>
    there
      .slice(at + 1)
      .filter(([, b]) => a.left + 1 < b.right && b.left + 1 < a.right && a.top + 1 < b.bottom && b.top + 1 < a.bottom)
      .map(([other]) => `${name} over ${other}`),
  );
  return [...outside, ...cut]
    .map(([name]) => name)
    .concat(over, document.documentElement.scrollWidth > width ? ["the page"] : []);
};
