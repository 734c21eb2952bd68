"use strict";
// Reads what `reports/page/replay_tracks.py` packed: event logs, and the balls' paths as parabolas.
globalThis.Ghostball ??= {};

(() => {
  const SCHEMA = 1;
  const PHASE = { RESTING: 0, SLIDING: 1, ROLLING: 2, UNKNOWN: 3, ABSENT: 4 };

  async function inflate(base64) {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    if (typeof DecompressionStream === "undefined") {
      throw new Error("this browser can't decompress; any of 2023 or later can");
    }
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** Reads the packed bytes from the first to the last. */
  class Reader {
    constructor(bytes) {
      this.bytes = bytes;
      this.at = 0;
    }

    /** One whole number, up to 2^53: no bit operations, they end at 2^31. */
    number() {
      let value = 0;
      let weight = 1;
      for (;;) {
        const byte = this.bytes[this.at++];
        if (byte === undefined) throw new Error("its motion is cut short");
        value += (byte % 128) * weight;
        if (byte < 128) break;
        weight *= 128;
      }
      return value % 2 ? -(value + 1) / 2 : value / 2;
    }

    numbers(count) {
      return Float64Array.from({ length: count }, () => this.number());
    }

    /** Differences to the one before, added up. */
    sums(count) {
      let sum = 0;
      return Float64Array.from({ length: count }, () => (sum += this.number()));
    }

    raw(count) {
      const part = this.bytes.subarray(this.at, this.at + count);
      if (part.length < count) throw new Error("its motion is cut short");
      this.at += count;
      return part;
    }

    /** Doubles, whose first bytes come first, then all second ones ... */
    doubles(count) {
      const planes = this.raw(8 * count);
      const view = new DataView(new ArrayBuffer(8));
      return Float64Array.from({ length: count }, (_, i) => {
        for (let k = 0; k < 8; k++) view.setUint8(k, planes[k * count + i]);
        return view.getFloat64(0, true);
      });
    }
  }

  function readEvents(reader) {
    const count = reader.number();
    return {
      count,
      t: reader.doubles(count),
      kind: reader.raw(count),
      a: reader.sums(count),
      b: reader.sums(count),
    };
  }

  /** The path of one ball: pieces between knots, each a parabola in time. */
  class Track {
    constructor(reader, knotTimes, quantum) {
      const scaled = (numbers) => numbers.map((value) => value * quantum);
      const knots = reader.number();
      const pieces = Math.max(knots - 1, 0);
      this.t = reader.sums(knots).map((index) => knotTimes[index]);
      this.phase = reader.raw(pieces);
      this.x = scaled(reader.sums(knots));
      this.y = scaled(reader.sums(knots));
      this.bowX = scaled(reader.numbers(pieces));
      this.bowY = scaled(reader.numbers(pieces));
      this.lost = Infinity;
    }

    /** The piece that holds an instant: the last that begins at it or before. */
    piece(t) {
      let low = 0;
      let high = this.phase.length - 1;
      while (low < high) {
        const middle = (low + high + 1) >> 1;
        if (this.t[middle] <= t) low = middle;
        else high = middle - 1;
      }
      return low;
    }

    /** [x, y] in metres; null where the ball is lost. It stays where its motion ends. */
    at(t) {
      const knots = this.t.length;
      if (knots === 0 || t >= this.lost) return null;
      if (t >= this.t[knots - 1]) return [this.x[knots - 1], this.y[knots - 1]];
      const i = this.piece(t);
      const u = Math.max((t - this.t[i]) / (this.t[i + 1] - this.t[i]), 0);
      const bow = 4 * u * (1 - u);
      return [
        this.x[i] + u * (this.x[i + 1] - this.x[i]) + bow * this.bowX[i],
        this.y[i] + u * (this.y[i + 1] - this.y[i]) + bow * this.bowY[i],
      ];
    }

    /** How the ball moves; UNKNOWN where the engine doesn't say. */
    phaseAt(t) {
      if (this.t.length === 0 || t >= this.lost) return PHASE.ABSENT;
      if (this.phase.length === 0) return PHASE.UNKNOWN;
      return this.phase[this.piece(t)];
    }
  }

  /** One engine of a scene, with its motion where it ran. */
  class Engine {
    constructor(said, reader, quantum, balls) {
      Object.assign(this, said);
      this.tracks = [];
      this.log = { count: 0, t: [], kind: [], a: [], b: [] };
      this.end = said.motion ? said.motion.end : 0;
      this.shown = false;
      if (!said.motion) return;
      this.log = readEvents(reader);
      const knotTimes = reader.sums(reader.number()).map((ticks) => ticks * said.motion.tick);
      this.tracks = Array.from({ length: balls }, () => new Track(reader, knotTimes, quantum));
      for (const [ball, t] of said.motion.lost) this.tracks[ball].lost = t;
    }

    positions(t) {
      return this.tracks.map((track) => track.at(t));
    }
  }

  /** Decodes a scene's data; counts how often that was done. */
  async function decode(data) {
    if (data.schema !== SCHEMA) {
      throw new Error(`its data are of version ${data.schema}, and this page reads ${SCHEMA}`);
    }
    Ghostball.decoded += 1;
    const reader = new Reader(await inflate(data.packed));
    const engines = data.engines.map(
      (said) => new Engine(said, reader, data.quantum, data.balls.length),
    );
    const duration = Math.max(0, ...engines.map((engine) => engine.end));
    return { ...data, engines, duration };
  }

  /** "cue hits 3", "cue hits the left cushion", "3 starts to roll", "3 comes to rest". */
  function eventWords(scene, kind, a, b) {
    const first = scene.balls[a]?.id ?? `ball ${a}`;
    switch (scene.kinds[kind]) {
      case "ball-ball":
        return `${first} hits ${scene.balls[b]?.id ?? `ball ${b}`}`;
      case "ball-cushion":
        return b in scene.cushions
          ? `${first} hits the ${scene.cushions[b]} cushion`
          : `${first} hits a cushion`;
      case "slide-to-roll":
        return `${first} starts to roll`;
      default:
        return `${first} comes to rest`;
    }
  }

  Ghostball.decoded = 0;
  Object.assign(Ghostball, { PHASE, decode, eventWords });
})();
