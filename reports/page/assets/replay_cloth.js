"use strict";
// The drawing beneath the balls: cloth, cushions, and a scale bar.
globalThis.Ghostball ??= {};

(() => {
  const { css } = Ghostball;
  const CUSHION_DEPTH = 0.045; // [m], as in the figures

  /** A round length for the scale bar: 1, 2 or 5 times a power of ten. */
  function roundLength(longest) {
    const power = 10 ** Math.floor(Math.log10(longest));
    return [5, 2, 1].map((step) => step * power).find((length) => length <= longest);
  }

  function lengthWords(metres) {
    const [value, unit] = metres >= 1 ? [metres, "m"]
      : metres >= 1e-3 ? [metres * 1e3, "mm"] : [metres * 1e6, "µm"];
    return `${Number(value.toPrecision(3))} ${unit}`;
  }

  /** Draws the table with its cushions, or an infinite cloth. */
  function drawCloth(plate) {
    const { context, theme, width, height } = plate;
    const { table } = plate.scene;
    context.fillStyle = css(table ? theme.paper : theme.cloth);
    context.fillRect(0, 0, width, height);
    if (!table) return;
    const { length, width: breadth } = table;
    const depth = CUSHION_DEPTH;
    const box = (x, y, dx, dy, colour) => {
      const [left, bottom] = plate.toPixels(x, y);
      const scale = plate.view.scale;
      context.fillStyle = css(colour);
      context.fillRect(left, bottom - dy * scale, dx * scale, dy * scale);
    };
    const disc = ([x, y, radius], colour) => {
      context.fillStyle = css(colour);
      context.beginPath();
      context.arc(...plate.toPixels(x, y), radius * plate.view.scale, 0, 2 * Math.PI);
      context.fill();
    };
    if (table.outline) {
      box(-depth, -depth, length + 2 * depth, breadth + 2 * depth, theme.cushion);
      context.fillStyle = css(theme.cloth);
      context.beginPath();
      for (const point of table.outline) context.lineTo(...plate.toPixels(...point));
      context.fill();
    } else {
      box(0, 0, length, breadth, theme.cloth);
    }
    for (const hole of table.holes ?? []) disc(hole, theme.ink);
    for (const post of table.posts ?? []) disc(post, theme.cushion);
    if (table.outline) return;
    const sides = {
      left: [[-depth, -depth, depth, breadth + 2 * depth], [0, 0, 0, breadth]],
      right: [[length, -depth, depth, breadth + 2 * depth], [length, 0, length, breadth]],
      bottom: [[-depth, -depth, length + 2 * depth, depth], [0, 0, length, 0]],
      top: [[-depth, breadth, length + 2 * depth, depth], [0, breadth, length, breadth]],
    };
    for (const [name, [bar, [x1, y1, x2, y2]]] of Object.entries(sides)) {
      if (table.cushions.includes(name)) {
        box(...bar, theme.cushion);
        continue;
      }
      context.strokeStyle = css(theme.muted);
      context.lineWidth = 1;
      context.setLineDash([2, 3]);
      context.beginPath();
      context.moveTo(...plate.toPixels(x1, y1));
      context.lineTo(...plate.toPixels(x2, y2));
      context.stroke();
      context.setLineDash([]);
    }
  }

  /** Draws a scale bar of a round length, with the length as text. */
  function drawScale(plate) {
    const { context, theme, height, view } = plate;
    const length = roundLength(Math.min(110, 0.3 * plate.width) / view.scale);
    const [x, y, long] = [10, height - 10, length * view.scale];
    const words = lengthWords(length);
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = css(theme.paper, 0.85);
    context.fillRect(x - 5, y - 20, Math.max(long, context.measureText(words).width) + 10, 25);
    context.strokeStyle = context.fillStyle = css(theme.ink);
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + long, y);
    context.stroke();
    context.textBaseline = "alphabetic";
    context.textAlign = "left";
    context.fillText(words, x, y - 5);
  }

  Object.assign(Ghostball, { drawCloth, drawScale, lengthWords });
})();
