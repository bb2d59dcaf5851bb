// Runs: the pictures of each, what holds in it now, and what happened.

/** What can be said of the kinds of events, each with a sign, so that no colour is needed. */
const SIGNS = {
  fault: "▼",
  healed: "▽",
  symptom: "▲",
  adaptation: "◆",
  cured: "●",
  log: "▪",
  end: "■",
  state: "○",
  well: "✓",
};

/** The pictures of one run, what holds now in words, and what happened in a list. */
class RunPane {
  constructor(run, pictures, isAlone) {
    this.run = run;
    this.number = page.runs.indexOf(run);
    this.panels = run.frames.panels.map((panel) => new PanelView(panel, run, page, pictures));
    this.times = run.events.map(({ time }) => time);
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
      this.element.prepend(
        element("h2", { class: `of${this.number}` }, nameOf(run)),
      );
    }
    this.pictures.addEventListener("pointermove", (event) => this.point(event));
    this.pictures.addEventListener("pointerleave", () => this.point(null));
  }

  item({ time, kind, text }) {
    const link = element(
      "a",
      { href: `#t=${time}`, class: kind },
      element("time", {}, `${time.toFixed(2)} s`),
      element("i", {}, SIGNS[kind] ?? ""),
      element("span", {}, text),
    );
    return element("li", {}, link);
  }

  /** The number of the frame of a time; -1 where there is none. */
  frameAt(time) {
    const { times } = this.run.frames;
    const frame = lastAtMost(times, time + 1e-6);
    return time - times[frame] > GAP_PERIODS * this.run.period ? -1 : frame;
  }

  load(frame) {
    return Promise.all(this.panels.map((panel) => panel.load(frame)));
  }

  tell(time) {
    const chips = holding(this.run, time).map(([kind, text]) =>
      element("span", { class: `chip ${kind}` }, `${SIGNS[kind]} ${text}`),
    );
    this.now.replaceChildren(...chips);
    this.now.style.minHeight = `${this.now.offsetHeight}px`; // what is below does not jump while chips come and go
    const current = lastAtMost(this.times, time + 1e-6);
    if (current === this.current) return;
    this.items[this.current]?.removeAttribute("aria-current");
    this.items[current]?.setAttribute("aria-current", "true");
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
    const at = box && {
      x: share(event.clientX, box.left, box.width),
      y: share(event.clientY, box.top, box.height),
    };
    for (const panel of this.panels) panel.point(at);
    const named = this.panels.filter(({ panel }) => panel.kind === "labels");
    const frame = this.frameAt(moment.time);
    const names = at
      ? await Promise.all(named.map((panel) => panel.className(frame, at)))
      : named.map(() => "");
    named.forEach((panel, place) => {
      panel.state.textContent = names[place];
    });
  }
}

/** What holds in a run at a time, as [kind, text]: faults, failures, states of nodes, what was just done or logged. */
function holding(run, time) {
  const told = [];
  const within = (since, until) => since <= time && (time < (until ?? Infinity) || until === run.end);
  for (const { name, spans, around } of run.faults) {
    if (!spans.some(([since, until]) => within(since, until))) continue;
    const isAround = around.some(([since, until]) => within(since, until));
    told.push(["fault", isAround ? `${name}, made up for` : name]);
  }
  for (const { name, description, topic, episodes } of run.failures) {
    const episode = episodes.find(({ holds, ended }) => within(holds, ended));
    if (!episode) continue;
    // what stops is silent from the beginning on; what a signal tells, it tells only from when it is seen
    const since = topic ? episode.began : episode.holds;
    told.push(["symptom", `${name} for ${(time - since).toFixed(1)} s: ${description}`]);
  }
  for (const { name, states } of run.nodes) {
    const state = states.find(({ since, until }) => within(since, until))?.state ?? "not there";
    if (states.length && state !== states[0].state)
      told.push(["state", `${name} is ${state}`]);
  }
  const lately = ({ time: then }) => then <= time + 1e-6 && time - then < 1;
  for (const { text } of run.adaptations.filter(lately)) told.push(["adaptation", text]);
  const logged = run.log.filter(lately).at(-1);
  if (logged) told.push(["log", `logged: ${logged.text}`]);
  if (!told.length) told.push(["well", time < 0 ? "warm-up: all is well" : "all is well"]);
  return told;
}
