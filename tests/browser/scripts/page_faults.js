// Text that is wider than its element, hangs out of the page, or is cut; of selects the text shown.
() => {
  const width = document.documentElement.clientWidth;
  const faults = document.documentElement.scrollWidth > width ? ["the page scrolls sideways"] : [];
  const pen = document.createElement("canvas").getContext("2d");
  const room = (each, style) => each.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight) + 1;
  const words = (each) => (each.textContent ?? "").trim().slice(0, 40);
  const skipped = ".unseen, .skip, pre, svg, .wide, .scroll, .tiles, ol.views, .stage > :not(.sheet)";
  for (const each of document.querySelectorAll("body *")) {
    if (!each.checkVisibility({ visibilityProperty: true }) || each.closest(skipped)) continue;
    const style = getComputedStyle(each);
    const box = each.getBoundingClientRect();
    const name = `${each.nodeName}#${each.id}.${each.className}`;
    if (box.width && (box.right > width + 1 || box.left < -1)) faults.push(`${name} leaves the page`);
    const shown = each.matches("select")
      ? each.selectedOptions[0]?.textContent.trim()
      : each.matches("input[placeholder]")
        ? each.placeholder
        : "";
    if (shown) {
      pen.font = style.font;
      if (pen.measureText(shown).width > room(each, style)) faults.push(`${name} cuts "${shown}"`);
    }
    const texts = "h1,h2,h3,p,li,td,th,dt,dd,a,button,summary,label,span,strong,code,figcaption";
    if (!each.matches(texts)) continue;
    if (style.display !== "inline" && each.scrollWidth > each.clientWidth + 1) {
      faults.push(`${name} is too narrow for "${words(each)}"`);
    }
    if (style.overflowY === "hidden" && each.scrollHeight > each.clientHeight + 2) {
      faults.push(`${name} cuts "${words(each)}"`);
    }
  }
  const actions = document.querySelectorAll("main :is(a[href]:not([href^='#']), button, input, select)");
  if (![...actions].some((each) => each.checkVisibility({ visibilityProperty: true }))) {
    faults.push("there is nothing to do next");
  }
  return faults;
};
