// The moment that is shown, and how it moves.

const AHEAD = 8; // frames that are unpacked before they are needed

class Moment {
  constructor(panes, lanes) {
    Object.assign(this, { panes, lanes, time: NaN, playing: null, speed: 1 });
    this.times = [
      ...new Set(
        panes.flatMap(({ run }) => run.events.filter(({ kind }) => kind !== "log").map(({ time }) => time)),
      ),
    ];
    this.times.sort((one, other) => one - other);
  }

  go(time) {
    const clamped = Math.min(Math.max(time, this.lanes.start), this.lanes.end);
    if (clamped === this.time || Number.isNaN(clamped)) return;
    this.time = clamped;
    byId("stage").dataset.asked = String(clamped);
    this.lanes.show(clamped);
    for (const pane of this.panes) pane.tell(clamped);
    byId("scrubber").value = clamped;
    byId("scrubber").setAttribute("aria-valuetext", `${clamped.toFixed(2)} seconds`);
    byId("time").textContent = `${clamped.toFixed(2)} s`;
    byId("link").href = `#t=${clamped}`; // all digits, so that it is this frame and no other
    this.draw();
  }

  /** Draw the pictures of the moment; while some are unpacked, only the last moment that was asked for waits. */
  async draw() {
    this.isAsked = true;
    if (this.isDrawing) return;
    this.isDrawing = true;
    try {
      while (this.isAsked) {
        this.isAsked = false;
        await this.drawFrames(this.time);
      }
    } finally {
      this.isDrawing = false;
    }
    this.lookAhead();
  }

  async drawFrames(time) {
    const shown = byId("stage").dataset;
    const frames = this.panes.map((pane) => pane.frameAt(time));
    if (String(frames) !== shown.frames) {
      const drawn = await Promise.all(this.panes.map((pane, number) => pane.load(frames[number])));
      for (const draw of drawn.flat()) draw();
      if (!shown.frames) performance.mark("first-frame");
      shown.frames = String(frames);
    }
    shown.time = String(time);
  }

  lookAhead() {
    for (const pane of this.panes) {
      const frame = pane.frameAt(this.time);
      const end = Math.min(frame + AHEAD, pane.run.frames.times.length - 1);
      for (let next = frame + 1; next <= end; next++) pane.load(next);
    }
  }

  step(by) {
    this.pause();
    const { times } = this.panes[0].run.frames;
    if (!times.length) return this.go(this.time + by * page.runs[0].period);
    const place = lastAtMost(times, this.time + 1e-6) + by;
    return this.go(times[Math.min(Math.max(place, 0), times.length - 1)]);
  }

  jump(by) {
    this.pause();
    const next =
      by > 0
        ? this.times.find((time) => time > this.time + 0.005)
        : this.times.findLast((time) => time < this.time - 0.005);
    this.go(next ?? (by > 0 ? this.lanes.end : this.lanes.start));
  }

  play() {
    if (this.time >= this.lanes.end) this.go(this.lanes.start);
    const playing = (this.playing = {}); // another one if it is paused and played again
    let before = performance.now();
    const advance = (now) => {
      if (this.playing !== playing) return;
      this.go(this.time + ((now - before) / 1000) * this.speed);
      before = now;
      if (this.time >= this.lanes.end) this.pause();
      else requestAnimationFrame(advance);
    };
    requestAnimationFrame(advance);
    byId("play").classList.add("playing");
  }

  pause() {
    this.playing = null;
    byId("play").classList.remove("playing");
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  faster(by) {
    const select = byId("speed");
    select.selectedIndex = Math.min(Math.max(select.selectedIndex + by, 0), select.options.length - 1);
    this.speed = Number(select.value);
  }
}

const KEYS = {
  " ": [() => moment.toggle(), "space", "play or pause"],
  ArrowLeft: [() => moment.step(-1), "←", "the frame before"],
  ArrowRight: [() => moment.step(1), "→", "the next frame"],
  p: [() => moment.jump(-1), "P", "the event before"],
  n: [() => moment.jump(1), "N", "the next event"],
  Home: [() => moment.go(moment.lanes.start), "Home", "the beginning"],
  End: [() => moment.go(moment.lanes.end), "End", "the end"],
  "-": [() => moment.faster(-1), "−", "slower"],
  "+": [() => moment.faster(1), "+", "faster"],
};
