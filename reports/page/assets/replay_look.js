"use strict";
// Colours of the page, light or dark, and the signs of engines.
globalThis.Ghostball ??= {};

(() => {
  const BLACK = "#000000"; // Ghostball's engine in figures on white; on the page it is the ink
  const FALLBACKS = {
    "--cloth": "#f1f5f2",
    "--cushion": "#8c9a91",
    "--ink": "#1a1a1a",
    "--muted": "#5c5c5c",
    "--paper": "#ffffff",
    "--accent": "#0b57d0",
  };

  /** Returns the current colours of the page, light or dark, as [red, green, blue]. */
  function readTheme(element) {
    const probe = document.createElement("span");
    const pixel = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
    const theme = {};
    element.append(probe);
    for (const [name, fallback] of Object.entries(FALLBACKS)) {
      probe.style.color = `var(${name}, ${fallback})`;
      pixel.fillStyle = fallback;
      pixel.fillStyle = getComputedStyle(probe).color;
      pixel.fillRect(0, 0, 1, 1);
      theme[name.slice(2)] = [...pixel.getImageData(0, 0, 1, 1).data.slice(0, 3)];
    }
    probe.remove();
    return theme;
  }

  const css = ([red, green, blue], alpha = 1) => `rgba(${red}, ${green}, ${blue}, ${alpha})`;

  function luminance(colour) {
    const [red, green, blue] = colour.map((part) => {
      const value = part / 255;
      return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  }

  function contrast(one, other) {
    const [low, high] = [luminance(one), luminance(other)].sort((p, q) => p - q);
    return (high + 0.05) / (low + 0.05);
  }

  /** Returns a colour ("#rrggbb") mixed with ink until its contrast with the cloth is enough. */
  function engineColour(hex, theme) {
    if (hex === BLACK) return theme.ink;
    const own = [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
    for (let share = 0; ; share += 0.1) {
      const mixed = own.map((part, i) => Math.round(part + share * (theme.ink[i] - part)));
      if (share >= 1 || contrast(mixed, theme.cloth) >= 3) return mixed;
    }
  }

  /** Draws the sign of an engine. Signs differ between families, so colour isn't needed. */
  function drawMarker(context, marker, x, y, size) {
    const polygon = (corners, turn, wide = 1) => {
      context.beginPath();
      for (let k = 0; k < corners; k++) {
        const angle = turn + (2 * Math.PI * k) / corners;
        context.lineTo(x + wide * size * Math.sin(angle), y - size * Math.cos(angle));
      }
      context.closePath();
      context.fill();
    };
    const cross = (turn) => {
      context.beginPath();
      for (const angle of [turn, turn + Math.PI / 2]) {
        const [dx, dy] = [size * Math.cos(angle), size * Math.sin(angle)];
        context.moveTo(x - dx, y - dy);
        context.lineTo(x + dx, y + dy);
      }
      context.stroke();
    };
    switch (marker) {
      case "s": return polygon(4, Math.PI / 4);
      case "D": return polygon(4, 0);
      case "^": return polygon(3, 0);
      case "v": return polygon(3, Math.PI);
      case "<": return polygon(3, -Math.PI / 2);
      case ">": return polygon(3, Math.PI / 2);
      case "p": return polygon(5, 0);
      case "h": return polygon(6, 0);
      case "H": return polygon(6, Math.PI / 6);
      case "d": return polygon(4, 0, 0.6);
      case "X": return cross(Math.PI / 4);
      case "P": return cross(0);
      case "*":
        cross(Math.PI / 4);
        return cross(0);
      default:
        context.beginPath();
        context.arc(x, y, 0.8 * size, 0, 2 * Math.PI);
        context.fill();
    }
  }

  Object.assign(Ghostball, { contrast, css, drawMarker, engineColour, readTheme });
})();
