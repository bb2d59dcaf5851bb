// Lanes: what happened, one below the other on one axis of time.

const GROUPS = {
  faults: [
    "Faults",
    "What the experiment broke, from its injection to its end. Hatched: it is there, but made up for.",
  ],
  failures: [
    "Failures",
    "What is seen of it. Pale: it has begun; full: the symptom holds. A tick: it was resolved.",
  ],
  adaptations: ["Adaptations", "What the managing system did, and what it logged."],
  iou: [
    "IoU",
    "How well the labels of each frame agree with the truth: 1 is perfect. A gap: no labels came.",
  ],
  signals: [
    "Symptoms",
    "What nodes report: dots. Line: the mean of five, which the dashed grey threshold is for.",
  ],
  topics: [
    "Rates",
    "Messages of the last second on every topic. 0 for a second is an outage, except of a node that is inactive.",
  ],
  nodes: ["Lifecycles", "The state of every node: only an active one does its work."],
};

const GAP_PERIODS = 2.5;

class Lanes {
  constructor(container, runs, seek) {
    Object.assign(this, { container, runs, seek, plots: [], readings: [] });
    this.start = Math.min(...runs.map((run) => run.start));
    this.end = Math.max(...runs.map((run) => run.end));
    this.head = element("div", { class: "head" });
    this.bodies = {};
    container.append(
      this.axis(),
      ...Object.keys(GROUPS).map((name) => this.group(name)),
      this.axis(),
      this.head,
    );
    this.fill();
    container.addEventListener("pointerdown", (event) => this.drag(event));
    new ResizeObserver(() => this.resize()).observe(container);
  }

  /** Where a time is on a track, in percent. */
  percent(time) {
    return (100 * (time - this.start)) / (this.end - this.start);
  }

  group(name) {
    const [title, text] = GROUPS[name];
    this.bodies[name] = element("div", { class: "rows" });
    const heading = element("h2", {}, title, " ", element("small", {}, text));
    return element("section", { class: `group ${name}` }, heading, this.bodies[name]);
  }

  /** Add a lane to a group; return its track. */
  row(group, name, { run, title = "", tall = false } = {}) {
    const track = element("div", { class: `track${tall ? " tall" : ""}` });
    const label = element("div", { class: "name", title }, element("span", {}, name));
    if (run && this.runs.length > 1)
      label.append(element("small", { class: `of${this.runs.indexOf(run)}` }, nameOf(run)));
    this.bodies[group].append(element("div", { class: "lane" }, label, track));
    if (this.start < 0)
      track.append(element("i", { class: "warm", style: { width: `${this.percent(0)}%` } }));
    return track;
  }

  /** Add a bar to a track, with a text, or the shorter one that fits. */
  bar(track, kind, since, until, [text = "", shorter = ""], title) {
    const [left, right] = [
      this.percent(Math.max(since, this.start)),
      this.percent(Math.min(until, this.end)),
    ];
    const style = { left: `${left}%`, width: `${Math.max(right - left, 0)}%` };
    track.append(element("div", { class: `bar ${kind}`, title, style }, right - left > 9 ? text : shorter));
  }

  /** Add marks at moments to a track, each with as much of its text as fits before the next, if that is enough. */
  marks(track, kind, items) {
    items.forEach(({ time, text, title }, number) => {
      const until = items[number + 1]?.time ?? this.end;
      const room = this.percent(until) - this.percent(time);
      const style = {
        left: `${this.percent(time)}%`,
        width: `calc(${room}% - .5rem)`,
      };
      track.append(
        element(
          "div",
          { class: `mark ${kind}`, title: `${time.toFixed(2)} s: ${title ?? text}`, style },
          element("span", {}, room > 9 ? text : ""),
        ),
      );
    });
  }

  fill() {
    this.each("faults", (fault, run) => this.fillFault(fault, run));
    this.each("failures", (failure, run) => failure.episodes.length && this.fillFailure(failure, run));
    for (const run of this.runs) this.fillAdaptations(run);
    this.fillLines();
    this.each("topics", (topic, run) => this.fillTopic(topic, run));
    this.each("nodes", (node, run) => this.fillNode(node, run));
    for (const body of Object.values(this.bodies)) body.parentElement.hidden = !body.children.length;
  }

  /** Call a function with everything of a kind, of both runs in turn. */
  each(kind, fill) {
    const names = new Set(this.runs.flatMap((run) => run[kind].map(({ name }) => name)));
    for (const name of names) {
      for (const run of this.runs) {
        for (const found of run[kind].filter((one) => one.name === name)) fill(found, run);
      }
    }
  }

  fillFault(fault, run) {
    const { name, description, failure, node } = fault;
    const track = this.row("faults", name, { run, title: description });
    for (const [since, until] of fault.spans) {
      const title = `${name} (${failure}, in ${node}) ${spanText(since, until)}. ${description}`;
      this.bar(track, "fault", since, until, [`${failure} · ${description}`, failure], title);
    }
    for (const [since, until] of fault.around) {
      this.bar(track, "around", since, until, [], `${name} is made up for ${spanText(since, until)}`);
    }
  }

  fillFailure({ name, description, episodes }, run) {
    const track = this.row("failures", name, { run, title: description });
    for (const { began, holds, ended, cause, outcome } of episodes) {
      const title = `${name} (${cause}): ${description}. It began at ${began.toFixed(2)} s, and its symptom held from ${holds.toFixed(2)} s on; ${outcome}`;
      if (began < holds) this.bar(track, "begun", began, holds, [], title);
      const kind = outcome.startsWith("resolved") ? "failure resolved" : "failure";
      const ripple = cause === "ripple" ? " (ripple)" : "";
      this.bar(track, kind, holds, ended ?? this.end, [`${description}${ripple} – ${outcome}`], title);
    }
  }

  fillNode({ name, states }, run) {
    const track = this.row("nodes", name, { run });
    for (const { since, until, state } of states) {
      this.bar(
        track,
        `state ${state}`,
        since,
        until,
        [state],
        `${name} is ${state} ${spanText(since, until)}`,
      );
    }
  }

  fillAdaptations(run) {
    const items = run.adaptations.map(({ time, text, resolved }) => ({
      time,
      text,
      title: resolved.length ? `${text}, which resolved ${resolved.join(", ")}` : text,
    }));
    this.marks(this.row("adaptations", "done", { run }), "adaptation", items);
    if (run.log.length) this.marks(this.row("adaptations", "logged", { run }), "log", run.log);
  }

  fillLines() {
    const [first] = this.runs;
    const iou = this.runs.map((run) => [run.iou[0], run.iou[1], []]);
    const top = Math.min(1, Math.ceil(11 * most(0.1, iou.flatMap(([, values]) => values))) / 10);
    if (iou.some(([times]) => times.length))
      this.lines("iou", "IoU", iou, { top, gap: GAP_PERIODS * first.period });
    for (const signal of first.signals) {
      const views = this.runs.map((run) => run.signals.find(({ name }) => name === signal.name));
      if (views.every((view) => !view?.times.length)) continue;
      const drawn = views.map((view) => [view?.times ?? [], view?.means ?? [], view?.values ?? []]);
      const failure = signal.failure
        ? ` (${signal.failure} ${signal.below ? "below" : "above"} the threshold)`
        : "";
      this.lines("signals", signal.name, drawn, {
        threshold: signal.threshold,
        unit: signal.unit,
        gap: 1,
        title: `${signal.name}${failure}`,
        note:
          signal.failure &&
          `${signal.failure} ${signal.below ? "below" : "above"} ${short(signal.threshold)}`,
      });
    }
  }

  /** Add a lane with a line for every run: [times, values of the line, values of the dots]. */
  lines(group, name, drawn, { top, threshold = null, unit = "", gap, title = "", note = "" }) {
    const track = this.row(group, name, { title, tall: true });
    const values = drawn.flatMap(([, line, dots]) => [...line, ...dots]).filter((value) => value !== null);
    const range = [-most(0, values.map((value) => -value)), top ?? 1.08 * most(threshold ?? 0, values)];
    const tables = drawn.map(([times, line, dots]) =>
      withGaps(times, dots.length ? [line, dots] : [line], gap),
    );
    const series = [{}];
    tables.forEach((table, number) => {
      series.push({
        stroke: () => css(`--line${number}`),
        width: 1.6,
        points: { show: false },
        dash: number ? [6, 3] : undefined,
      });
      if (table.length > 2) {
        const points = { show: true, size: 2.5, width: 0, fill: () => css(`--line${number}`) };
        series.push({ stroke: () => css(`--line${number}`), paths: () => null, points, alpha: 0.45 });
      }
    });
    if (threshold !== null) {
      tables.push([
        [this.start, this.end],
        [threshold, threshold],
      ]);
      series.push({ stroke: () => css("--threshold"), width: 1.2, dash: [3, 3], points: { show: false } });
    }
    this.plot(track, uPlot.join(tables, tables.map(withoutBridges)), series, range);
    track.append(
      element("small", { class: "top" }, `${short(range[1])} ${unit}`),
      element("small", { class: "bottom" }, short(range[0])),
    );
    if (note) track.append(element("small", { class: "note" }, note));
    drawn.forEach(([times, line], number) => {
      this.reading(track, number, (time) => {
        const place = lastAtMost(times, time);
        const value = place < 0 || time - times[place] > Math.max(gap, 0.3) ? null : line[place];
        return value === null ? "–" : `${value.toFixed(2)} ${unit}`;
      });
    });
  }

  fillTopic({ name, node, times }, run) {
    const grid = [];
    const step = Math.max(run.period, (this.end - this.start) / 5000);
    for (let time = this.start; time <= this.end; time += step) grid.push(time);
    const sent = (time) => lastAtMost(times, time) - lastAtMost(times, time - 1);
    const rates = grid.map(sent);
    const track = this.row("topics", name.replace("/managed_subsystem/", ""), {
      run,
      title: `${name}, from ${node}`,
    });
    const line = {
      stroke: () => css("--rate"),
      fill: () => css("--rate-fill"),
      width: 1,
      points: { show: false },
    };
    const top = most(1, rates);
    this.plot(track, [grid, rates], [{}, line], [0, top]);
    track.append(element("small", { class: "top" }, `${top} Hz`));
    this.reading(track, this.runs.indexOf(run), (time) => `${sent(time)} Hz`);
  }

  /** Add the current value of a lane beside its name. */
  reading(track, number, textAt) {
    const place = element("output", { class: `of${number}` });
    track.parentElement.firstElementChild.append(place);
    this.readings.push([place, textAt]);
  }

  plot(track, data, series, range) {
    const made = new uPlot(
      {
        width: 100,
        height: track.clientHeight || 24,
        padding: [1, 0, 1, 0],
        legend: { show: false },
        cursor: { show: false },
        axes: [{ show: false }, { show: false }],
        scales: { x: { time: false, range: () => [this.start, this.end] }, y: { range: () => range } },
        series,
      },
      data,
      track,
    );
    this.plots.push([made, track]);
  }

  axis() {
    const track = element("div", { class: "track ticks" });
    const steps = [0.5, 1, 2, 5, 10, 20, 60, 120, 300, 600];
    const step = steps.find((one) => (this.end - this.start) / one <= 14) ?? 1800;
    for (let time = Math.ceil(this.start / step) * step; time <= this.end; time += step) {
      track.append(element("span", { style: { left: `${this.percent(time)}%` } }, time ? `${time}` : "0 s"));
    }
    return element(
      "div",
      { class: "lane axis" },
      element("div", { class: "name" }, "seconds of the measured time"),
      track,
    );
  }

  /** Where tracks begin and how wide they are, in pixels of the container. */
  measure() {
    const track = this.container.querySelector(".track").getBoundingClientRect();
    return { left: track.left - this.container.getBoundingClientRect().left, width: track.width };
  }

  resize() {
    this.place = this.measure();
    for (const [plot, track] of this.plots)
      plot.setSize({ width: track.clientWidth, height: track.clientHeight });
    this.show(this.time ?? 0);
  }

  redraw() {
    for (const [plot] of this.plots) plot.redraw(false);
  }

  /** Move to a time. */
  show(time) {
    this.time = time;
    this.place ??= this.measure();
    this.head.style.transform = `translateX(${this.place.left + (this.place.width * this.percent(time)) / 100}px)`;
    for (const [place, textAt] of this.readings) {
      const text = textAt(time);
      if (place.textContent !== text) place.textContent = text;
    }
  }

  drag(event) {
    if (!event.target.closest(".track") || event.button) return;
    const seekTo = ({ clientX }) => {
      const left = this.container.getBoundingClientRect().left + this.place.left;
      this.seek(this.start + ((clientX - left) / this.place.width) * (this.end - this.start));
    };
    const stop = new AbortController();
    addEventListener("pointermove", seekTo, { signal: stop.signal });
    for (const name of ["pointerup", "pointercancel"])
      addEventListener(name, () => stop.abort(), { signal: stop.signal });
    seekTo(event);
  }
}

/** A colour or another value of the style sheet. */
function css(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** A number in few digits. */
function short(value) {
  return String(Number(value.toPrecision(3)));
}

/** The largest of a number and others, which may be more than a function takes as arguments. */
function most(first, others) {
  return others.reduce((one, other) => Math.max(one, other), first);
}

function spanText(since, until) {
  return since === until ? `at ${since.toFixed(2)} s` : `from ${since.toFixed(2)} s to ${until.toFixed(2)} s`;
}

/** How uPlot joins the columns of a table: a gap (null) stays one among the times of other tables, too. */
function withoutBridges(columns) {
  return columns.map(() => 2);
}

/** Times and columns of values with an empty place in every gap that is longer than so many seconds. */
function withGaps(times, columns, longest) {
  const table = [[], ...columns.map(() => [])];
  times.forEach((time, place) => {
    if (place && time - times[place - 1] > longest) {
      table[0].push((time + times[place - 1]) / 2);
      for (const column of table.slice(1)) column.push(null);
    }
    table[0].push(time);
    columns.forEach((column, number) => table[number + 1].push(column[place]));
  });
  return table;
}
