// Contrast of every text of a page with what is painted behind it (WCAG 2, 1.4.3).
// Returns the texts below the wanted ratio. Tests run it inside the page.
(wanted) => {
  const parse = (colour) => {
    const parts = colour.match(/[\d.]+/g).map(Number);
    return { rgb: parts.slice(0, 3), alpha: parts.length > 3 ? parts[3] : 1 };
  };
  const luminance = (rgb) => {
    const [r, g, b] = rgb.map((part) => {
      const c = part / 255;
      return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ratio = (a, b) => {
    const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
    return (high + 0.05) / (low + 0.05);
  };
  const blend = (over, alpha, under) => over.map((c, i) => alpha * c + (1 - alpha) * under[i]);
  const layers = new Map();  // by element, asked once: most texts have theirs in common
  const layersBehind = (element) => {  // backgrounds of elements, from the outside in
    if (!element) return { colour: parse(getComputedStyle(document.body).backgroundColor).rgb, bar: null };
    if (!layers.has(element)) {
      const under = layersBehind(element.parentElement);
      const style = getComputedStyle(element);
      const own = parse(style.backgroundColor);
      const image = style.backgroundImage.match(/rgba?\([^)]*\)/);
      layers.set(element, {
        colour: blend(own.rgb, own.alpha, under.colour),
        bar: image ? parse(image[0]).rgb : under.bar,
      });
    }
    return layers.get(element);
  };
  const paintedBehind = (element) => {
    const { colour, bar } = layersBehind(element);
    return bar ? [colour, bar] : [colour];
  };
  const stackAt = (text) => {  // what is painted at the middle of a text, uppermost first
    const box = text.getBoundingClientRect();
    return document.elementsFromPoint(box.x + box.width / 2, box.y + box.height / 2);
  };
  const paintedInFigure = (text) => {  // the uppermost shape below the middle of a text
    let stack = stackAt(text);
    if (stack.length === 0 || !text.contains(stack[0])) {  // out of sight, or covered
      text.scrollIntoView({ block: "center", inline: "center" });
      stack = stackAt(text);
    }
    for (const shape of stack) {
      if (shape === text || text.contains(shape)) continue;
      if (!shape.ownerSVGElement) break;
      const style = getComputedStyle(shape);
      if (shape.closest("text") || !/^rgb/.test(style.fill)) continue;
      const fill = parse(style.fill);
      const alpha = fill.alpha * style.fillOpacity * style.opacity;
      if (alpha > 0) return [blend(fill.rgb, alpha, paintedBehind(text.closest("div"))[0])];
    }
    return paintedBehind(text.closest("div"));
  };
  const poor = [];
  let texts = 0;
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement;
    if (!walker.currentNode.data.trim() || element.closest("script, style, title")) continue;
    if (!element.checkVisibility() || element.getClientRects().length === 0) continue;
    const figure = element.closest("svg") ? element.closest("text") : null;
    const style = getComputedStyle(element);
    const ink = parse(figure ? style.fill : style.color);
    const behind = figure ? paintedInFigure(figure) : paintedBehind(element);
    texts += 1;
    for (const paper of behind) {
      const found = ratio(blend(ink.rgb, ink.alpha * style.opacity, paper), paper);
      if (found < wanted) poor.push(`${found.toFixed(2)} ${walker.currentNode.data.trim().slice(0, 60)}`);
    }
  }
  return { texts, poor: [...new Set(poor)] };
}
