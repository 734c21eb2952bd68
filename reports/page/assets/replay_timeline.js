"use strict";
// The time line: a native slider under a strip of marks, with one shape for each kind of event.
globalThis.Ghostball ??= {};

(() => {
  const { css, drawMarker, timeWords } = Ghostball;
  const INSET = 8; // [px], half the slider's thumb: the middle of the thumb marks the time
  const LANES = ["ball-ball", "ball-cushion", "slide-to-roll", "roll-to-rest", "ball-cloth"];
  const ON_CLOTH = 4; // number of lanes if no ball flies
  const LANE_HEIGHT = 11; // [px]
  const FLAGS_HEIGHT = 16; // [px]
  const LEAST_DISTANCE = 3; // [px]: marks closer together are drawn as one mark

  /** Draws the sign of a kind of event. */
  function drawKind(context, lane, x, y) {
    const size = 3.2;
    context.beginPath();
    if (lane === 0) context.arc(x, y, size, 0, 2 * Math.PI);
    else if (lane === 1) context.rect(x - size + 0.4, y - size + 0.4, 2 * size - 0.8, 2 * size - 0.8);
    else if (lane === 2) {
      context.moveTo(x, y - size - 0.6);
      context.lineTo(x + size + 0.4, y + size);
      context.lineTo(x - size - 0.4, y + size);
      context.closePath();
    } else if (lane === 4) {
      context.moveTo(x, y + size + 0.6);
      context.lineTo(x + size + 0.4, y - size);
      context.lineTo(x - size - 0.4, y - size);
      context.closePath();
    } else context.rect(x - 1, y - size - 0.8, 2, 2 * size + 1.6);
    context.fill();
  }

  /** Slider and marks; dragging the slider calls `onseek(t)`. */
  class Timeline {
    constructor(host, plate, duration, onseek) {
      this.plate = plate;
      this.lanes = plate.scene.highest > 0 ? LANES : LANES.slice(0, ON_CLOTH);
      this.duration = duration;
      this.time = 0;
      this.kinds = [];
      this.log = null;
      this.flags = [];
      this.canvas = document.createElement("canvas");
      this.canvas.className = "gb-marks";
      this.marks = document.createElement("canvas"); // thousands of marks, drawn only once
      [this.marks.width, this.marks.height] = [0, 0];
      this.canvas.setAttribute("aria-hidden", "true"); // the list of events has the same in words
      this.slider = document.createElement("input");
      Object.assign(this.slider, { type: "range", min: 0, max: duration, step: "any", value: 0 });
      this.slider.className = "gb-slider";
      this.slider.setAttribute("aria-label", "Time");
      this.slider.addEventListener("input", () => onseek(Number(this.slider.value)));
      this.host = host;
      host.append(this.canvas, this.slider);
      this.canvas.addEventListener("pointerdown", (event) => {
        const left = this.canvas.getBoundingClientRect().left;
        onseek(this.timeAt(event.clientX - left));
        this.slider.focus();
      });
    }

    get height() {
      return FLAGS_HEIGHT + this.lanes.length * LANE_HEIGHT;
    }

    get width() {
      return this.host.clientWidth;
    }

    placeOf(t) {
      return INSET + (this.duration > 0 ? t / this.duration : 0) * (this.width - 2 * INSET);
    }

    timeAt(x) {
      const part = (x - INSET) / Math.max(this.width - 2 * INSET, 1);
      return Math.min(Math.max(part, 0), 1) * this.duration;
    }

    /** Shows the events of a log, and flags at some times: [{t, engine, text}]. */
    show(kinds, log, flags) {
      Object.assign(this, { kinds, log, flags });
      this.drawMarks();
    }

    setTime(t) {
      this.time = t;
      this.slider.value = t;
      this.draw();
    }

    /** Tells screen readers the time; not called for each frame. */
    say() {
      this.slider.setAttribute(
        "aria-valuetext", `${timeWords(this.time, 3)} of ${timeWords(this.duration, 3)}`);
    }

    /** Draws the line at the current time over the marks, which are not drawn again. */
    draw() {
      const { canvas, marks } = this;
      if (!marks.width || canvas.width !== marks.width) return;
      const context = canvas.getContext("2d");
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.drawImage(marks, 0, 0);
      const ratio = canvas.height / this.height;
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      const now = this.placeOf(this.time);
      context.strokeStyle = css(this.plate.theme.accent);
      context.lineWidth = 1.5;
      context.beginPath();
      context.moveTo(now, 0);
      context.lineTo(now, this.height);
      context.stroke();
    }

    drawMarks() {
      const { plate, width, canvas, marks } = this;
      if (!plate.theme || !width) return;
      const { height } = this;
      const ratio = globalThis.devicePixelRatio || 1;
      if (canvas.width !== Math.round(width * ratio)) {
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
        canvas.style.height = `${height}px`;
      }
      [marks.width, marks.height] = [canvas.width, canvas.height];
      const context = marks.getContext("2d");
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, height);
      context.strokeStyle = css(plate.theme.muted, 0.35);
      context.lineWidth = 1;
      context.beginPath();
      for (let lane = 0; lane < this.lanes.length; lane++) {
        const y = FLAGS_HEIGHT + (lane + 0.5) * LANE_HEIGHT;
        context.moveTo(INSET, y);
        context.lineTo(width - INSET, y);
      }
      context.stroke();
      this.drawEvents(context);
      for (const flag of this.flags) this.drawFlag(context, flag, height);
      this.draw();
    }

    drawEvents(context) {
      const { log, plate } = this;
      if (!log) return;
      context.fillStyle = css(plate.theme.ink);
      const last = this.lanes.map(() => -Infinity);
      for (let i = 0; i < log.count; i++) {
        const lane = this.lanes.indexOf(this.kinds[log.kind[i]]);
        const x = this.placeOf(log.t[i]);
        if (lane < 0 || x - last[lane] < LEAST_DISTANCE) continue;
        last[lane] = x;
        drawKind(context, lane, x, FLAGS_HEIGHT + (lane + 0.5) * LANE_HEIGHT);
      }
    }

    /** Draws a flag with the sign of its engine, or a dashed flag without an engine, and its text. */
    drawFlag(context, { t, engine, text }, height) {
      const x = this.placeOf(t);
      const colour = engine ? this.plate.colourOf(engine) : this.plate.theme.ink;
      context.strokeStyle = context.fillStyle = css(colour);
      context.lineWidth = 1.5;
      context.setLineDash(engine ? [] : [3, 3]);
      context.beginPath();
      context.moveTo(x, engine ? 12 : 2);
      context.lineTo(x, height);
      context.stroke();
      context.setLineDash([]);
      if (engine) drawMarker(context, engine.marker, x, 7, 5);
      if (!text) return;
      context.font = "12px system-ui, sans-serif";
      context.fillStyle = css(this.plate.theme.ink);
      context.textBaseline = "middle";
      const left = x + 10 + context.measureText(text).width > this.width;
      context.textAlign = left ? "right" : "left";
      context.fillText(text, left ? x - 8 : x + 8, 7);
    }
  }

  Object.assign(Ghostball, { Timeline, drawKind });
})();
