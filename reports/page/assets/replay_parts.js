"use strict";
// Helpers for all parts of the replay: elements, icons, words for times.
globalThis.Ghostball ??= {};

(() => {
  const SVG = "http://www.w3.org/2000/svg";
  // Icons of 16 by 16, drawn as paths, because some fonts lack these arrows.
  const ICONS = {
    start: "M3 2h2v12H3zM14 2v12L6 8z",
    back: "M11 2v12L3 8zM12 2h2v12h-2z",
    play: "M3 1v14l11-7z",
    pause: "M3 2h4v12H3zM9 2h4v12H9z",
    next: "M5 2v12l8-6zM2 2h2v12H2z",
    end: "M11 2h2v12h-2zM2 2v12l8-6z",
    closer: "M7 2h2v5h5v2H9v5H7V9H2V7h5z",
    farther: "M2 7h12v2H2z",
    whole: "M2 2h5v2H4v3H2zM9 2h5v5h-2V4H9zM2 9h2v3h3v2H2zM12 9h2v5H9v-2h3z",
    ball: "M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1zm0 2a5 5 0 1 1 0 10A5 5 0 0 1 8 3zm0 3a2 2 0 1 0 0 4 2 2 0 0 0 0-4z",
  };

  /** Makes an element with properties and children; strings become text, never markup. */
  function make(tag, properties = {}, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(properties)) {
      if (name in element) element[name] = value;
      else element.setAttribute(name, value);
    }
    element.append(...children);
    return element;
  }

  function icon(name) {
    const picture = document.createElementNS(SVG, "svg");
    picture.setAttribute("viewBox", "0 0 16 16");
    picture.setAttribute("aria-hidden", "true");
    const path = document.createElementNS(SVG, "path");
    path.setAttribute("d", ICONS[name]);
    picture.append(path);
    return picture;
  }

  /** Makes a button with an icon; its label names the action, its tooltip also the key. */
  function iconButton(name, label, act, key = "") {
    const button = make("button", { type: "button", className: "gb-icon" }, icon(name));
    relabel(button, label, key);
    button.addEventListener("click", act);
    return button;
  }

  function relabel(button, label, key = "") {
    button.title = key ? `${label} (${key})` : label;
    button.setAttribute("aria-label", label);
  }

  function tick(text, checked, act) {
    const box = make("input", { type: "checkbox", checked });
    box.addEventListener("change", () => act(box.checked));
    return make("label", { className: "gb-tick" }, box, text);
  }

  /** Makes a drop-down list of [[value, text], ...]. */
  function choice(label, options, chosen, act) {
    const select = make("select", {}, ...options.map(([value, text]) =>
      make("option", { value, textContent: text })));
    select.value = chosen;
    select.addEventListener("change", () => act(select.value));
    return [make("label", { className: "gb-choice" }, `${label} `, select), select];
  }

  /** Draws on a small canvas with the resolution of the screen. */
  function drawSmall(canvas, width, theme, paint) {
    const ratio = globalThis.devicePixelRatio || 1;
    canvas.width = width * ratio;
    canvas.height = 16 * ratio;
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = context.strokeStyle = Ghostball.css(theme.ink);
    paint(context, theme);
  }

  const timeWords = (t, digits = 4) => `${t.toFixed(digits)} s`;

  Object.assign(Ghostball, {
    choice, drawSmall, icon, iconButton, make, relabel, tick, timeWords,
  });
})();
