// The page, made of what it knows; it is the last of the scripts.

const page = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);

function setTheme(name) {
  document.documentElement.dataset.theme = name;
  moment.lanes.redraw();
}

/** The time that the address says, or another. */
function timeOfAddress(otherwise) {
  const found = /[#&]t=(-?\d*\.?\d+(?:e-?\d+)?)/.exec(location.hash);
  return found ? Number(found[1]) : otherwise;
}

fillHead();
fillFigures();
fillLegend();
const pictures = new Pictures(page.pictures);
const panes = page.runs.map((run) => new RunPane(run, pictures, page.runs.length === 1));
byId("stage").append(...panes.map((pane) => pane.element));
byId("stage").classList.toggle("both", page.runs.length > 1);
if (page.pictures.data.length) byId("stage").after(colourKey());
const moment = new Moment(
  panes,
  new Lanes(byId("lanes"), page.runs, (time) => {
    moment.pause();
    moment.go(time);
  }),
);

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
  event.target.blur(); // so that keys move the moment again
});
byId("theme").addEventListener("click", () =>
  setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"),
);
// on paper it is always light
let themeOfScreen = document.documentElement.dataset.theme;
addEventListener("beforeprint", () => {
  themeOfScreen = document.documentElement.dataset.theme;
  setTheme("light");
});
addEventListener("afterprint", () => setTheme(themeOfScreen));
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
addEventListener("resize", () => panes.forEach(({ now }) => (now.style.minHeight = "")));
const dark = matchMedia("(prefers-color-scheme: dark)");
dark.addEventListener("change", () => setTheme(dark.matches ? "dark" : "light"));
setTheme(dark.matches ? "dark" : "light");
moment.go(timeOfAddress(page.opening));
// a browser without these shows no pictures or colours; an older one does not come so far
if (self.DecompressionStream && CSS.supports("color", "color-mix(in srgb, red, blue)")) byId("needs").remove();
