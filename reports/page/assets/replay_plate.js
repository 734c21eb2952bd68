"use strict";
// The table seen from above, on a canvas: what is where at an instant, and how to look closer.
globalThis.Ghostball ??= {};

(() => {
  const { PHASE, css, contrast, drawMarker, engineColour, readTheme } = Ghostball;
  const CUSHION_DEPTH = 0.045; // [m], as the figures draw them
  const CLOSEST = 2e6; // pixels per metre: a micrometre is 2 pixels
  const SMALLEST_BALL = 3.5; // [px]: on a large cloth a ball to scale would be a speck
  const TRUTH_ARM = 6; // [px]
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

  /** A canvas over the cloth with its view; `paint(plate)` draws what is on it. */
  class Plate {
    constructor(host, scene, paint) {
      this.scene = scene;
      this.paint = paint;
      this.canvas = document.createElement("canvas");
      this.canvas.className = "gb-canvas";
      this.context = this.canvas.getContext("2d");
      host.append(this.canvas);
      this.host = host;
      this.width = this.height = 0;
      this.view = null;
      this.fitted = true;
      this.pointers = new Map();
      this.pending = 0;
      this.listen();
    }

    listen() {
      this.gone = new AbortController();
      const { signal } = this.gone;
      this.sizes = new ResizeObserver(() => this.resize());
      this.sizes.observe(this.host);
      const refresh = () => this.refresh();
      matchMedia("(prefers-color-scheme: dark)").addEventListener("change", refresh, { signal });
      matchMedia("print").addEventListener("change", refresh, { signal });
      const canvas = this.canvas;
      canvas.addEventListener("wheel", (event) => {
        // A page that scrolls past a replay must not be held up by it.
        if (!event.ctrlKey && !this.host.contains(document.activeElement)) return;
        event.preventDefault();
        this.zoom(Math.exp(-0.002 * event.deltaY), this.placeOf(event));
      }, { signal, passive: false });
      canvas.addEventListener("pointerdown", (event) => {
        if (event.pointerType !== "mouse" && this.fitted && this.pointers.size === 0) {
          // One finger on the whole table scrolls the page; two fingers, or a closer view, are ours.
          this.pointers.set(event.pointerId, event);
          return;
        }
        this.pointers.set(event.pointerId, event);
        canvas.setPointerCapture(event.pointerId);
      }, { signal });
      canvas.addEventListener("pointermove", (event) => this.drag(event), { signal });
      for (const end of ["pointerup", "pointercancel"]) {
        canvas.addEventListener(end, (event) => this.pointers.delete(event.pointerId), { signal });
      }
      canvas.addEventListener("dblclick", (event) => this.zoom(2, this.placeOf(event)), { signal });
    }

    destroy() {
      this.gone.abort();
      this.sizes.disconnect();
      cancelAnimationFrame(this.pending);
      this.canvas.remove();
    }

    placeOf(event) {
      const box = this.canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    }

    drag(event) {
      const before = this.pointers.get(event.pointerId);
      if (!before) return;
      const others = [...this.pointers.values()].filter((one) => one.pointerId !== event.pointerId);
      this.pointers.set(event.pointerId, event);
      if (others.length === 1) {
        const apart = (one) => Math.hypot(
          one.clientX - others[0].clientX, one.clientY - others[0].clientY);
        this.zoom(apart(event) / Math.max(apart(before), 1), this.placeOf(event));
      } else if (others.length === 0 && (event.pointerType === "mouse" || !this.fitted)) {
        this.view.x -= (event.clientX - before.clientX) / this.view.scale;
        this.view.y += (event.clientY - before.clientY) / this.view.scale;
        this.fitted = false;
        this.moved();
      }
    }

    resize() {
      const width = this.host.clientWidth;
      if (width === 0) return;
      const [left, right, bottom, top] = this.scene.view;
      const aspect = (top - bottom) / (right - left);
      const height = Math.round(
        Math.min(Math.max(width * aspect, 120), Math.max(0.62 * innerHeight, 240)));
      const ratio = globalThis.devicePixelRatio || 1;
      this.width = width;
      this.height = height;
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
      this.canvas.style.height = `${height}px`;
      this.ratio = ratio;
      if (this.fitted || !this.view) this.view = this.whole();
      this.refresh();
    }

    /** The view that shows everything: its centre [m] and its pixels per metre. */
    whole() {
      const [left, right, bottom, top] = this.scene.view;
      return {
        x: (left + right) / 2,
        y: (bottom + top) / 2,
        scale: Math.min(this.width / (right - left), this.height / (top - bottom)),
      };
    }

    reset() {
      this.fitted = true;
      this.view = this.whole();
      this.moved();
    }

    /** Looks closer by a factor, with the given pixel staying where it is. */
    zoom(factor, place = [this.width / 2, this.height / 2]) {
      if (!this.view) return;
      const [x, y] = this.toMetres(...place);
      const least = this.whole().scale / 4;
      this.view.scale = Math.min(Math.max(this.view.scale * factor, least), CLOSEST);
      const [nowX, nowY] = this.toMetres(...place);
      this.view.x += x - nowX;
      this.view.y += y - nowY;
      this.fitted = false;
      this.moved();
    }

    /** Looks at a place [m], at least so close that a ball fills a quarter of the plate. */
    lookAt([x, y], radius) {
      const scale = Math.min(this.width, this.height) / (8 * radius);
      this.view = { x, y, scale: Math.max(scale, this.view.scale) };
      this.fitted = false;
      this.moved();
    }

    moved() {
      this.canvas.classList.toggle("gb-closer", !this.fitted);
      this.draw();
      this.onview?.();
    }

    toPixels(x, y) {
      const { x: midX, y: midY, scale } = this.view;
      return [this.width / 2 + (x - midX) * scale, this.height / 2 - (y - midY) * scale];
    }

    toMetres(px, py) {
      const { x, y, scale } = this.view;
      return [x + (px - this.width / 2) / scale, y - (py - this.height / 2) / scale];
    }

    /** Reads the page's colours anew, and draws. */
    refresh() {
      if (!this.width) return;
      this.theme = readTheme(this.host);
      this.colours = new Map();
      this.draw();
    }

    colourOf(engine) {
      if (!this.colours.has(engine.colour)) {
        this.colours.set(engine.colour, engineColour(engine.colour, this.theme));
      }
      return this.colours.get(engine.colour);
    }

    /** Draws before the next frame, however often it is asked to. */
    draw() {
      if (this.pending || !this.width) return;
      this.pending = requestAnimationFrame(() => {
        this.pending = 0;
        this.drawNow();
      });
    }

    drawNow() {
      const context = this.context;
      context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
      this.drawCloth();
      this.paint(this);
      this.drawScale();
    }

    drawCloth() {
      const { context, theme, width, height } = this;
      const { table } = this.scene;
      context.fillStyle = css(table ? theme.paper : theme.cloth);
      context.fillRect(0, 0, width, height);
      if (!table) return;
      const { length, width: breadth } = table;
      const depth = CUSHION_DEPTH;
      const box = (x, y, dx, dy, colour) => {
        const [left, bottom] = this.toPixels(x, y);
        const scale = this.view.scale;
        context.fillStyle = css(colour);
        context.fillRect(left, bottom - dy * scale, dx * scale, dy * scale);
      };
      box(0, 0, length, breadth, theme.cloth);
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
        context.moveTo(...this.toPixels(x1, y1));
        context.lineTo(...this.toPixels(x2, y2));
        context.stroke();
        context.setLineDash([]);
      }
    }

    drawScale() {
      const { context, theme, height, view } = this;
      const length = roundLength(Math.min(110, 0.3 * this.width) / view.scale);
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

    /** The path of a ball from one instant to another; its sliding parts, or all others. */
    path(track, since, t, sliding) {
      const { context } = this;
      const { x, y, bowX, bowY } = track;
      const until = Math.min(t, track.lost);
      let pen = false;
      context.beginPath();
      for (let i = track.piece(since); i < track.phase.length && track.t[i] < until; i++) {
        if ((track.phase[i] === PHASE.SLIDING) !== sliding) {
          pen = false;
          continue;
        }
        const dt = track.t[i + 1] - track.t[i];
        const from = dt > 0 ? Math.min(Math.max((since - track.t[i]) / dt, 0), 1) : 0;
        const to = dt > 0 ? Math.min((until - track.t[i]) / dt, 1) : 1;
        // A parabola in time is a Bezier curve: its tangents meet in the middle of its time.
        const place = (ends, bow, u) => ends[i] + u * (ends[i + 1] - ends[i]) + 4 * u * (1 - u) * bow[i];
        const slope = (ends, bow) => ends[i + 1] - ends[i] + 4 * (1 - 2 * from) * bow[i];
        const [startX, startY] = [place(x, bowX, from), place(y, bowY, from)];
        const half = (to - from) / 2;
        if (!pen) context.moveTo(...this.toPixels(startX, startY));
        pen = true;
        context.quadraticCurveTo(
          ...this.toPixels(startX + half * slope(x, bowX), startY + half * slope(y, bowY)),
          ...this.toPixels(place(x, bowX, to), place(y, bowY, to)),
        );
      }
    }

    /** Paths of all balls of an engine up to an instant: sliding ones wider and darker. */
    drawTrails(engine, t, since = 0) {
      const { context } = this;
      const colour = this.colourOf(engine);
      for (const sliding of [false, true]) {
        if (sliding && !engine.motion.phases) continue;
        const alpha = engine.ours ? 0.3 : 0.9;
        context.strokeStyle = css(colour, sliding ? Math.min(2 * alpha, 1) : alpha);
        context.lineWidth = (engine.ours ? 4.5 : 1.4) + (sliding ? 2.5 : 0);
        context.setLineDash(engine.dash.map((part) => 1.4 * part));
        for (const track of engine.tracks) {
          this.path(track, since, t, sliding);
          context.stroke();
        }
      }
      context.setLineDash([]);
    }

    pixelRadius(ball) {
      return Math.max(this.scene.balls[ball].radius * this.view.scale, SMALLEST_BALL);
    }

    /** Balls where an engine has them: ours filled, others as outlines with their sign. */
    drawBalls(engine, t, { names = true, filled = engine.ours } = {}) {
      const { context, theme } = this;
      const colour = this.colourOf(engine);
      engine.positions(t).forEach((place, ball) => {
        if (!place) return;
        const [x, y] = this.toPixels(...place);
        const radius = this.pixelRadius(ball);
        context.beginPath();
        context.arc(x, y, radius, 0, 2 * Math.PI);
        if (filled) {
          context.fillStyle = css(colour, 0.82);
          context.fill();
          if (names && radius > 7) this.drawName(ball, x, y, radius, colour);
          return;
        }
        context.strokeStyle = context.fillStyle = css(colour);
        context.lineWidth = 1.6;
        context.setLineDash(engine.dash.map((part) => 1.2 * part));
        context.stroke();
        context.setLineDash([]);
        if (radius > SMALLEST_BALL) {
          // Each engine at its own hour of the clock: where all agree, every sign is still seen.
          const angle = (2 * Math.PI * this.scene.engines.indexOf(engine)) / this.scene.engines.length;
          const [dx, dy] = [radius * Math.sin(angle), -radius * Math.cos(angle)];
          drawMarker(context, engine.marker, x + dx, y + dy, Math.min(4.5, 0.4 * radius));
        }
      });
    }

    drawName(ball, x, y, radius, colour) {
      const { context, theme } = this;
      const name = this.scene.balls[ball].id;
      const size = Math.min((2.6 * radius) / Math.max(name.length, 2.4), radius, 40);
      if (size < 6) return;
      context.font = `600 ${size}px system-ui, sans-serif`;
      context.textAlign = "center";
      context.textBaseline = "middle";
      context.fillStyle = css(contrast(colour, theme.paper) > contrast(colour, theme.ink)
        ? theme.paper : theme.ink);
      context.fillText(name, x, y);
    }

    /** Where the balls rest in truth: crosses, thin enough to see a tenth of a millimetre. */
    drawTruth(rest) {
      const { context, theme } = this;
      context.strokeStyle = css(theme.accent);
      context.lineWidth = 1.2;
      context.beginPath();
      for (const place of rest) {
        if (!place) continue;
        const [x, y] = this.toPixels(...place);
        context.moveTo(x - TRUTH_ARM, y);
        context.lineTo(x + TRUTH_ARM, y);
        context.moveTo(x, y - TRUTH_ARM);
        context.lineTo(x, y + TRUTH_ARM);
      }
      context.stroke();
    }

    /** A ring around the ball whose numbers are read out. */
    drawChosen(place, ball) {
      const { context, theme } = this;
      context.strokeStyle = css(theme.accent);
      context.lineWidth = 2.5;
      context.beginPath();
      context.arc(...this.toPixels(...place), this.pixelRadius(ball) + 4, 0, 2 * Math.PI);
      context.stroke();
    }
  }

  Object.assign(Ghostball, { Plate, lengthWords });
})();
