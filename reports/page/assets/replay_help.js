"use strict";
// The legend of a replay, its keys, and its accuracy.
globalThis.Ghostball ??= {};

(() => {
  const { PHASE, css, drawKind, lengthWords, make } = Ghostball;
  const KIND_WORDS = ["balls collide", "cushion", "starts to roll", "comes to rest", "lands"];
  const KEYS = [
    ["Space", "play or pause"],
    ["← →", "back or forward 1 % of the run; with Shift 0.1 %"],
    ["Home End", "start, end"],
    ["p n", "previous event, next event"],
    ["d", "first wrong collision"],
    ["[ ]", "slower, faster"],
    ["+ - 0", "zoom in, zoom out, whole table"],
    ["b", "zoom to the selected ball"],
    ["drag, wheel, pinch", "pan and zoom (the wheel works once the replay has focus)"],
  ];

  /** Returns the legend and its signs as [canvas, paint]. `lanes`: number of kinds of events. */
  function legend(engines, truth, lanes) {
    const signs = [];
    const list = make("ul", { className: "gb-legend" });
    const add = (draw, text) => {
      const sign = make("canvas", { className: "gb-sign" });
      sign.setAttribute("aria-hidden", "true");
      signs.push([sign, draw]);
      list.append(make("li", {}, sign, text));
    };
    KIND_WORDS.slice(0, lanes).forEach((text, lane) => add((context) => drawKind(context, lane, 14, 8), text));
    const slides = (track) => track.phase.includes(PHASE.SLIDING);
    if (engines.some((engine) => engine.tracks.some(slides))) {
      const stroke = (width, alpha) => (context, theme) => {
        context.strokeStyle = css(theme.ink, alpha);
        context.lineWidth = width;
        context.beginPath();
        context.moveTo(2, 8);
        context.lineTo(26, 8);
        context.stroke();
      };
      add(stroke(4.5, 0.3), "rolls (Ghostball)");
      add(stroke(7, 0.6), "slides (Ghostball)");
    }
    if (truth) {
      add((context, theme) => {
        context.strokeStyle = css(theme.accent);
        context.lineWidth = 1.5;
        context.beginPath();
        context.moveTo(8, 8);
        context.lineTo(20, 8);
        context.moveTo(14, 2);
        context.lineTo(14, 14);
        context.stroke();
      }, `reference rest position (${truth.kind})`);
    }
    return { list, signs };
  }

  function help(scene) {
    const list = make("dl");
    for (const [key, what] of KEYS) {
      list.append(make("div", {}, make("dt", { textContent: key }), make("dd", { textContent: what })));
    }
    return make("fieldset", { className: "gb-help" },
      make("legend", { textContent: "Keys and accuracy" }), list,
      make("p", { textContent:
        `Paths run within ${lengthWords(scene.tolerance)} of the stored samples and are interpolated between them. ` +
        "Times of events and positions at the end are exact. Stripes rotate with the recorded spin." }));
  }

  Object.assign(Ghostball, { help, legend });
})();
