"use strict";
// The table seen from above, on a canvas: balls and paths at a given time, zoom and pan.
globalThis.Ghostball ??= {};

(() => {
  const {
    FROM_ABOVE, PHASE, contrast, css, drawCloth, drawMarker, drawScale, drawStripe, engineColour, readTheme,
  } = Ghostball;
  const CLOSEST = 2e5; // [px/m]: the accuracy of paths, 0.01 mm, is 2 pixels
  const SMALLEST_BALL = 3.5; // [px]: a ball to scale would be invisible on a large cloth
  const MARGIN = 20; // [px]: around the canvas, so that the ends of cut lines are invisible
  const LONGEST = 4000; // [px]: longer curves are drawn in parts
  const TRUTH_ARM = 6; // [px]
  const SUN = 0.6; // offset of a shadow to the right and downwards, over the height of the ball
  const STRIPED = 7; // [px]: least radius of a ball with a visible stripe
  /** A canvas with the cloth and a view; `paint(plate)` draws on it. */
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
        // The wheel must scroll the page past a replay unless the replay has the focus.
        if (!event.ctrlKey && !this.host.contains(document.activeElement)) return;
        event.preventDefault();
        this.zoom(Math.exp(-0.002 * event.deltaY), this.placeOf(event));
      }, { signal, passive: false });
      canvas.addEventListener("pointerdown", (event) => {
        if (event.pointerType !== "mouse" && this.fitted && this.pointers.size === 0) {
          // One finger on the whole table scrolls the page. Two fingers, or one finger on a
          // zoomed view, move the view.
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
        const distance = (one) => Math.hypot(
          one.clientX - others[0].clientX, one.clientY - others[0].clientY);
        this.zoom(distance(event) / Math.max(distance(before), 1), this.placeOf(event));
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

    /** Returns the view of the whole table: centre [m] and pixels per metre. */
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

    /** Zooms by a factor; the point at the given pixel stays in place. */
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

    /** Centres the view at a point [m]; the length `span` [m] fills the canvas. */
    lookAt([x, y], span) {
      this.view = { x, y, scale: Math.min(Math.min(this.width, this.height) / span, CLOSEST) };
      this.fitted = false;
      this.moved();
    }

    /** The length [m] that now fills the canvas. */
    get span() {
      return Math.min(this.width, this.height) / this.view.scale;
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

    /** Reads the colours of the page again, and draws. */
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

    /** Draws once before the next frame, for any number of calls. */
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
      drawCloth(this);
      this.paint(this);
      drawScale(this);
    }

    /** Adds the path of a ball between two times: only the sliding parts, or only the other parts. */
    path(track, since, t, sliding) {
      const until = Math.min(t, track.lost);
      this.context.beginPath();
      this.pen = false;
      for (let i = track.piece(since); i < track.phase.length && track.t[i] < until; i++) {
        if ((track.phase[i] === PHASE.SLIDING) !== sliding) {
          this.pen = false;
          continue;
        }
        const dt = track.t[i + 1] - track.t[i];
        const from = dt > 0 ? Math.min(Math.max((since - track.t[i]) / dt, 0), 1) : 0;
        const to = dt > 0 ? Math.min((until - track.t[i]) / dt, 1) : 1;
        this.curve(track, i, from, to);
      }
    }

    /** Adds a part of one piece, without invisible parts: long dashed lines take seconds to draw. */
    curve({ x, y, bowX, bowY }, i, from, to) {
      const place = (ends, bow, u) => ends[i] + u * (ends[i + 1] - ends[i]) + 4 * u * (1 - u) * bow[i];
      const slope = (ends, bow, u) => ends[i + 1] - ends[i] + 4 * (1 - 2 * u) * bow[i];
      // A parabola in time is a Bezier curve. The tangents at its ends meet at mid-time.
      const draw = (u0, u1) => {
        const [startX, startY] = [place(x, bowX, u0), place(y, bowY, u0)];
        const half = (u1 - u0) / 2;
        const start = this.toPixels(startX, startY);
        const middle = this.toPixels(startX + half * slope(x, bowX, u0), startY + half * slope(y, bowY, u0));
        const end = this.toPixels(place(x, bowX, u1), place(y, bowY, u1));
        const [left, right, top, bottom] = [0, 1].flatMap((axis) => {
          const three = [start[axis], middle[axis], end[axis]];
          return [Math.min(...three), Math.max(...three)];
        });
        if (right < -MARGIN || left > this.width + MARGIN
          || bottom < -MARGIN || top > this.height + MARGIN) {
          this.pen = false;
        } else if (Math.max(right - left, bottom - top) > LONGEST) {
          draw(u0, (u0 + u1) / 2);
          draw((u0 + u1) / 2, u1);
        } else {
          if (!this.pen) this.context.moveTo(...start);
          this.pen = true;
          this.context.quadraticCurveTo(...middle, ...end);
        }
      };
      draw(from, to);
    }

    /** Draws the paths of all balls of an engine up to time t; sliding parts wider and darker. */
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

    /** Draws the balls of an engine: Ghostball's filled, others as outlines with the engine's sign. */
    drawBalls(engine, t, { names = true, stripes = false, filled = engine.ours } = {}) {
      const colour = this.colourOf(engine);
      engine.positions(t).forEach((place, ball) => {
        if (!place) return;
        const [x, y] = this.toPixels(...place);
        const radius = this.pixelRadius(ball);
        // Here the edge of the ball is outside the canvas, and only its centre shows differences.
        const close = radius > Math.min(this.width, this.height) / 3;
        if (radius < LONGEST) this.drawDisc(engine, x, y, radius, filled, close);
        if (stripes && !close && radius > STRIPED) {
          this.drawStripeOf(this.context, engine, ball, t, x, y, radius, FROM_ABOVE);
        }
        if (close) this.drawCentre(engine, x, y, filled);
        else if (filled && names && radius > 7) this.drawName(ball, x, y, radius, colour);
        else if (!filled && radius > SMALLEST_BALL) this.drawSign(engine, x, y, radius);
      });
    }

    drawDisc(engine, x, y, radius, filled, close) {
      const { context } = this;
      const colour = this.colourOf(engine);
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
      if (filled) {
        context.fillStyle = css(colour, close ? 0.12 : 0.82);
        context.fill();
        return;
      }
      context.strokeStyle = css(colour);
      context.lineWidth = 1.6;
      context.setLineDash(engine.dash.map((part) => 1.2 * part));
      context.stroke();
      context.setLineDash([]);
    }

    /** Draws the shadows of flying balls, at a distance proportional to the height. */
    drawShadows(engine, t, filled = engine.ours) {
      if (this.scene.highest === 0) return;
      const { context } = this;
      context.fillStyle = css(this.theme.ink, filled ? 0.28 : 0.1);
      engine.positions(t).forEach((place, ball) => {
        const height = place ? place[2] - this.scene.balls[ball].radius : 0;
        if (!(height > 0)) return;
        const [x, y] = this.toPixels(...place);
        const away = SUN * height * this.view.scale;
        context.beginPath();
        context.arc(x + away, y + away, this.pixelRadius(ball), 0, 2 * Math.PI);
        context.fill();
      });
    }

    /** Draws the stripe of a ball in its orientation; `seen` projects directions (see drawStripe). */
    drawStripeOf(context, engine, ball, t, x, y, radius, seen) {
      const colour = this.colourOf(engine);
      const { ink, paper } = this.theme;
      const light = contrast(colour, paper) > contrast(colour, ink) ? paper : ink;
      context.strokeStyle = context.fillStyle = css(engine.ours ? light : colour, 0.85);
      context.lineWidth = engine.ours ? Math.max(0.14 * radius, 1.5) : 1.2;
      drawStripe(context, engine.tracks[ball].orientation(t), x, y, radius, seen);
    }

    /** Draws an engine's sign at its own angle on the edge, so signs of equal balls don't overlap. */
    drawSign(engine, x, y, radius) {
      const { context } = this;
      const { engines } = this.scene;
      const angle = (2 * Math.PI * engines.indexOf(engine)) / engines.length;
      const [dx, dy] = [radius * Math.sin(angle), -radius * Math.cos(angle)];
      context.strokeStyle = context.fillStyle = css(this.colourOf(engine));
      context.lineWidth = 1.6;
      drawMarker(context, engine.marker, x + dx, y + dy, Math.min(4.5, 0.4 * radius));
    }

    /** Draws the centre of a ball: Ghostball's as a ring with a cross, others as the engine's sign. */
    drawCentre(engine, x, y, filled) {
      const { context } = this;
      context.strokeStyle = context.fillStyle = css(this.colourOf(engine));
      context.lineWidth = 1.6;
      if (!filled) {
        drawMarker(context, engine.marker, x, y, 6);
        return;
      }
      context.beginPath();
      context.arc(x, y, 9, 0, 2 * Math.PI);
      for (const [dx, dy] of [[14, 0], [0, 14]]) {
        context.moveTo(x - dx, y - dy);
        context.lineTo(x + dx, y + dy);
      }
      context.stroke();
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

    /** Draws reference rest positions as crosses, thin enough to show 0.1 mm. */
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

    /** Draws a ring around the selected ball, whose numbers the table shows. */
    drawChosen(place, ball) {
      if (this.pixelRadius(ball) > LONGEST) return;
      const { context, theme } = this;
      context.strokeStyle = css(theme.accent);
      context.lineWidth = 2.5;
      context.beginPath();
      context.arc(...this.toPixels(...place), this.pixelRadius(ball) + 4, 0, 2 * Math.PI);
      context.stroke();
    }
  }

  Object.assign(Ghostball, { Plate });
})();
