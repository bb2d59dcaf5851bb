"use strict";

// The page: what is shown of each run, and the moment that is shown.

const page = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);

/** What can be said of the kinds of events, each with a sign, so that no colour is needed. */
const SIGNS = { fault: "▼", symptom: "▲", adaptation: "◆", cured: "●", log: "▪", end: "■", state: "○", well: "✓" };
const MEANINGS = {
  cured: "a symptom is gone",
  log: "the managing system logged something",
  end: "the end of the run",
  state: "a node is in another state than at first",
  well: "there is nothing to say",
};
const AHEAD = 8; // frames that are unpacked before they are needed

/** The pictures of one run, what holds now in words, and what happened in a list. */
class RunPane {
  constructor(run, pictures, isAlone) {
    this.run = run;
    this.number = page.runs.indexOf(run);
    this.panels = run.frames.panels.map((panel) => new PanelView(panel, run, page, pictures));
    this.now = element("p", { class: "now" });
    this.pictures = element("div", { class: "pictures" }, ...this.panels.map(({ figure }) => figure));
    this.items = run.events.map((event) => this.item(event));
    this.list = element("ol", { class: "events", "aria-label": "Events", tabindex: "0" }, ...this.items);
    this.element = element(
      "article",
      { class: `run${isAlone ? " alone" : ""}${this.panels.length ? "" : " bare"}` },
      element("div", { class: "seen" }, this.pictures, this.now),
      this.list,
    );
    if (!isAlone) {
      this.element.prepend(element("h2", { class: `of${this.number}` }, `${"AB"[this.number]}: ${run.manager}`));
    }
    this.pictures.addEventListener("pointermove", (event) => this.point(event));
    this.pictures.addEventListener("pointerleave", () => this.point(null));
  }

  item({ time, kind, text }) {
    const link = element(
      "a",
      { href: `#t=${time.toFixed(2)}`, class: kind },
      element("time", {}, `${time.toFixed(2)} s`),
      element("i", {}, SIGNS[kind] ?? ""),
      element("span", {}, text),
    );
    return element("li", {}, link);
  }

  /** The number of the frame of a time; -1 before the first one. */
  frameAt(time) {
    return lastAtMost(this.run.frames.times, time + 1e-6);
  }

  load(frame) {
    return Promise.all(this.panels.map((panel) => panel.load(frame)));
  }

  tell(time) {
    const chips = holding(this.run, time).map(([kind, text]) => element("span", { class: `chip ${kind}` }, `${SIGNS[kind]} ${text}`));
    this.now.replaceChildren(...chips);
    const current = lastAtMost(this.run.events.map((event) => event.time), time + 1e-6);
    if (current === this.current) return;
    this.items[this.current]?.classList.remove("current");
    this.items[current]?.classList.add("current");
    this.items.forEach((item, place) => item.classList.toggle("later", place > current));
    this.current = current;
    const item = this.items[Math.max(current, 0)];
    if (item) this.list.scrollTop = item.offsetTop - this.list.clientHeight / 2;
  }

  /** Show the pixel that is pointed at in all pictures, and its classes. */
  async point(event) {
    const picture = event?.target.closest(".picture");
    const box = picture?.getBoundingClientRect();
    const share = (value, least, size) => Math.min(Math.max((value - least) / size, 0), 0.9999);
    const at = box && { x: share(event.clientX, box.left, box.width), y: share(event.clientY, box.top, box.height) };
    for (const panel of this.panels) panel.point(at);
    const named = this.panels.filter(({ panel }) => panel.kind === "labels");
    const frame = this.frameAt(moment.time);
    const names = at ? await Promise.all(named.map((panel) => panel.className(frame, at))) : named.map(() => "");
    named.forEach((panel, place) => {
      panel.state.textContent = names[place];
    });
  }
}

/** What holds in a run at a time, as [kind, text]: faults, failures, states of nodes, what was just done or logged. */
function holding(run, time) {
  const told = [];
  const within = (since, until) => since <= time && time < (until ?? Infinity);
  for (const { name, spans, around } of run.faults) {
    if (!spans.some(([since, until]) => within(since, until))) continue;
    const isAround = around.some(([since, until]) => within(since, until));
    told.push(["fault", isAround ? `${name}, made up for` : name]);
  }
  for (const { name, description, episodes } of run.failures) {
    const episode = episodes.find(({ holds, ended }) => within(holds, ended));
    if (episode) told.push(["symptom", `${name} for ${(time - episode.began).toFixed(1)} s: ${description}`]);
  }
  for (const { name, states } of run.nodes) {
    const state = states.find(({ since, until }) => within(since, until))?.state ?? "not there";
    if (states.length && state !== states[0].state && time < run.end) told.push(["state", `${name} is ${state}`]);
  }
  const lately = ({ time: then }) => then <= time + 1e-6 && time - then < 1;
  for (const { text } of run.adaptations.filter(lately)) told.push(["adaptation", text]);
  const logged = run.log.filter(lately).at(-1);
  if (logged) told.push(["log", `logged: ${logged.text}`]);
  if (!told.length) told.push(["well", time < 0 ? "warm-up: all is well" : "all is well"]);
  return told;
}

/** The moment that is shown, and how it moves. */
class Moment {
  constructor(panes, lanes) {
    Object.assign(this, { panes, lanes, time: NaN, playing: false, speed: 1 });
    this.times = [...new Set(panes.flatMap(({ run }) => run.events.filter(({ kind }) => kind !== "log").map(({ time }) => time)))];
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
    byId("link").href = `#t=${clamped.toFixed(2)}`;
    this.draw();
  }

  /** Draw the pictures of the moment; while some are unpacked, only the last moment that was asked for waits. */
  async draw() {
    this.isAsked = true;
    if (this.isDrawing) return;
    this.isDrawing = true;
    while (this.isAsked) {
      this.isAsked = false;
      const { time } = this;
      const frames = this.panes.map((pane) => pane.frameAt(time));
      if (String(frames) !== byId("stage").dataset.frames) {
        const drawn = await Promise.all(this.panes.map((pane, number) => pane.load(frames[number])));
        for (const draw of drawn.flat()) draw();
        if (!byId("stage").dataset.frames) performance.mark("first-frame");
        byId("stage").dataset.frames = String(frames);
      }
      byId("stage").dataset.time = String(time);
    }
    this.isDrawing = false;
    this.lookAhead();
  }

  lookAhead() {
    for (const pane of this.panes) {
      const frame = pane.frameAt(this.time);
      for (let next = frame + 1; next <= frame + AHEAD && next < pane.run.frames.times.length; next++) pane.load(next);
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
    const next = by > 0 ? this.times.find((time) => time > this.time + 0.005) : this.times.findLast((time) => time < this.time - 0.005);
    this.go(next ?? (by > 0 ? this.lanes.end : this.lanes.start));
  }

  play() {
    if (this.time >= this.lanes.end) this.go(this.lanes.start);
    this.playing = true;
    let before = performance.now();
    const advance = (now) => {
      if (!this.playing) return;
      this.go(this.time + ((now - before) / 1000) * this.speed);
      before = now;
      if (this.time >= this.lanes.end) this.pause();
      else requestAnimationFrame(advance);
    };
    requestAnimationFrame(advance);
    byId("play").classList.add("playing");
  }

  pause() {
    this.playing = false;
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

function setTheme(name) {
  document.documentElement.dataset.theme = name;
  moment.lanes.redraw();
}

/** The time that the address says, or another. */
function timeOfAddress(otherwise) {
  const found = /[#&]t=(-?\d*\.?\d+)/.exec(location.hash);
  return found ? Number(found[1]) : otherwise;
}

function fillHead() {
  // a line may end after a sign between two names
  for (const part of page.title.split(/(?<=[+/])/)) document.querySelector("h1").append(part, element("wbr"));
  byId("lead").querySelector("span").textContent = page.runs.length > 1 ? "two runs of the same faults" : "one run";
  const managers = page.runs.map(({ manager }, number) => (page.runs.length > 1 ? `${"AB"[number]}: ${manager}` : manager));
  byId("described").textContent = `managing system ${managers.join(", ")} · ${page.runs[0].described}`;
  byId("story").textContent = (page.comparison.length ? page.comparison : page.runs[0].story).join(" ");
  const remarks = page.runs.map(({ remark, manager }) => remark && (page.runs.length > 1 ? `${manager}: ${remark}` : remark));
  byId("remark").textContent = remarks.filter(Boolean).join(" ");
  byId("remark").hidden = !remarks.some(Boolean);
}

function fillFigures() {
  const table = element("table", {}, element("caption", {}, "How well it went"));
  if (page.runs.length > 1) {
    const names = page.runs.map(({ manager }, number) => element("th", { scope: "col", class: `of${number}` }, manager));
    table.append(element("tr", {}, element("th", {}), ...names));
  }
  page.runs[0].figures.forEach(({ name }, place) => {
    const cells = page.runs.map(({ figures }) =>
      element("td", {}, element("b", {}, figures[place].value), " ", element("small", {}, figures[place].remark)),
    );
    table.append(element("tr", {}, element("th", { scope: "row" }, name), ...cells));
  });
  byId("figures").append(table);
}

function fillLegend() {
  const terms = (title, pairs) =>
    element("section", {}, element("h3", {}, title), element("dl", {}, ...pairs.flatMap(([term, text]) => [element("dt", {}, term), element("dd", {}, text)])));
  const [run] = page.runs;
  const parts = [
    terms("The system", [
      ["managed system", "A drone's perception: colour and depth images are fused, and a network gives every pixel a class."],
      ["fault", "A cause, which the experiment injects. Several faults look alike from outside."],
      ["failure", "What is seen of it: one of those below. One failure may bring others about, which is called a ripple."],
      ["managing system", "It sees symptoms only, and adapts the managed system: sets parameters, changes topics, restarts or redeploys nodes."],
    ]),
    terms("Failures", run.failures.map(({ name, description, symptom }) => [name, `${description}. Symptom: ${symptom}.`])),
    terms("Pictures", run.frames.panels.map(({ title, explanation }) => [title, explanation])),
    terms("Lanes", Object.values(GROUPS)),
    terms("Signs", Object.entries(SIGNS).map(([kind, sign]) => [sign, MEANINGS[kind] ?? kind])),
    terms("Keys", Object.values(KEYS).map(([, key, text]) => [key, text])),
  ];
  if (run.faults.length) {
    parts.splice(2, 0, terms("Faults of this run", run.faults.map(({ name, failure, description }) => [name, `${failure}. ${description}`])));
  }
  byId("legend").querySelector(".columns").append(...parts);
  document.querySelector("footer").textContent = `${page.pictures.note} Written by 'sunset view', SUNSET ${page.version}.`;
}

/** The colours of the classes and of the depth, below the pictures. */
function colourKey() {
  const key = element("p", { class: "key" });
  for (const index of page.pictures.classes) {
    const { name, colour } = page.classes[index];
    key.append(element("span", {}, element("i", { style: { background: colour } }), name));
  }
  const { depth } = page.pictures;
  if (depth) {
    const ramp = element("i", { class: "ramp", style: { background: `linear-gradient(to right, ${depth.colours.join(", ")})` } });
    key.append(element("span", {}, `depth ${short(depth.near)} m `, ramp, ` ${short(depth.far)} m`));
  }
  return key;
}

fillHead();
fillFigures();
fillLegend();
const pictures = new Pictures(page.pictures);
const panes = page.runs.map((run) => new RunPane(run, pictures, page.runs.length === 1));
byId("stage").append(...panes.map((pane) => pane.element));
byId("stage").classList.toggle("both", page.runs.length > 1);
if (page.pictures.data.length) byId("stage").after(colourKey());
const moment = new Moment(panes, new Lanes(byId("lanes"), page.runs, (time) => {
  moment.pause();
  moment.go(time);
}));

const scrubber = byId("scrubber");
Object.assign(scrubber, { min: moment.lanes.start, max: moment.lanes.end, step: "any" });
scrubber.addEventListener("input", () => {
  moment.pause();
  moment.go(Number(scrubber.value));
});
byId("play").addEventListener("click", () => moment.toggle());
byId("previous").addEventListener("click", () => moment.jump(-1));
byId("next").addEventListener("click", () => moment.jump(1));
byId("back").addEventListener("click", () => moment.step(-1));
byId("forward").addEventListener("click", () => moment.step(1));
byId("speed").addEventListener("change", (event) => {
  moment.speed = Number(event.target.value);
});
byId("theme").addEventListener("click", () => setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
addEventListener("keydown", (event) => {
  const isTaken = event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select");
  const isPressed = event.key === " " && event.target.matches("button, a, summary");
  const found = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!found || isTaken || isPressed) return;
  event.preventDefault();
  found[0]();
});
// in a notebook's frame, an address would lead elsewhere
document.addEventListener("click", (event) => {
  const link = event.target.closest("a[href^='#']");
  if (!link) return;
  event.preventDefault();
  if (link.hash === "#legend") {
    byId("legend").open = true;
    byId("legend").scrollIntoView();
    return;
  }
  moment.pause();
  moment.go(Number(link.hash.slice(3)));
  if (location.protocol !== "about:") history.replaceState(null, "", link.hash);
});
if (window.parent !== window) byId("legend").open = false;
addEventListener("hashchange", () => {
  moment.pause();
  moment.go(timeOfAddress(moment.time));
});
const dark = matchMedia("(prefers-color-scheme: dark)");
dark.addEventListener("change", () => setTheme(dark.matches ? "dark" : "light"));
setTheme(dark.matches ? "dark" : "light");
moment.go(timeOfAddress(Math.max(0, ...page.runs.flatMap(({ faults }) => faults.map(({ spans }) => spans[0]?.[0] ?? 0)))));
