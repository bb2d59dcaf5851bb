// What surrounds the pictures and lanes: head, figures, explanations.

const MEANINGS = {
  healed: "a fault has healed by itself",
  cured: "a symptom is gone",
  log: "the managing system logged something",
  end: "the end of the run",
  state: "a node is in another state than at first",
  well: "there is nothing to say",
};

function fillHead() {
  // a line may end after a sign between two names
  for (const part of page.title.split(/(?<=[+/])/)) document.querySelector("h1").append(part, element("wbr"));
  byId("lead").querySelector("span").textContent =
    page.runs.length > 1 ? "two runs of the same faults" : "one run";
  byId("described").textContent = `managing system ${page.runs.map(nameOf).join(", ")} · ${page.runs[0].described}`;
  byId("story").textContent = (page.comparison.length ? page.comparison : page.runs[0].story).join(" ");
  const remarks = page.runs.map(
    (run) => run.remark && (page.runs.length > 1 ? `${nameOf(run)}. ${run.remark}` : run.remark),
  );
  byId("remark").textContent = remarks.filter(Boolean).join(" ");
  byId("remark").hidden = !remarks.some(Boolean);
}

function fillFigures() {
  const table = element("table", {}, element("caption", {}, "How well it went"));
  if (page.runs.length > 1) {
    const names = page.runs.map((run, number) =>
      element("th", { scope: "col", class: `of${number}` }, nameOf(run)),
    );
    table.append(element("tr", {}, element("th", {}), ...names));
  }
  page.runs[0].figures.forEach(({ name }, place) => {
    const cells = page.runs.map(({ figures }) =>
      element(
        "td",
        {},
        element("b", {}, figures[place].value),
        " ",
        element("small", {}, figures[place].remark),
      ),
    );
    table.append(element("tr", {}, element("th", { scope: "row" }, name), ...cells));
  });
  byId("figures").append(table);
}

function fillLegend() {
  const terms = (title, pairs) =>
    element(
      "section",
      {},
      element("h3", {}, title),
      element(
        "dl",
        {},
        ...pairs.flatMap(([term, text]) => [element("dt", {}, term), element("dd", {}, text)]),
      ),
    );
  const [run] = page.runs;
  const parts = [
    terms("The system", [
      [
        "managed system",
        "A drone's perception: colour and depth images are fused, and a network gives every pixel a class.",
      ],
      ["fault", "A cause, which the experiment injects. Several faults look alike from outside."],
      [
        "failure",
        "What is seen of it: one of those below. One failure may bring others about, which is called a ripple.",
      ],
      [
        "managing system",
        "It sees symptoms only, and adapts the managed system: sets parameters, changes topics, restarts or redeploys nodes.",
      ],
    ]),
    terms(
      "Failures",
      run.failures.map(({ name, description, symptom }) => [name, `${description}. Symptom: ${symptom}.`]),
    ),
    terms(
      "Pictures",
      run.frames.panels.map(({ title, explanation }) => [title, explanation]),
    ),
    terms("Lanes", Object.values(GROUPS)),
    terms(
      "Signs",
      Object.entries(SIGNS).map(([kind, sign]) => [sign, MEANINGS[kind] ?? kind]),
    ),
    terms(
      "Keys",
      Object.values(KEYS).map(([, key, text]) => [key, text]),
    ),
  ];
  if (run.faults.length) {
    parts.splice(
      2,
      0,
      terms(
        "Faults of this run",
        run.faults.map(({ name, failure, description }) => [name, `${failure}. ${description}`]),
      ),
    );
  }
  byId("legend")
    .querySelector(".columns")
    .append(...parts);
  document.querySelector("footer").textContent =
    `${page.pictures.note} Written by 'sunset view', SUNSET ${page.version}.`;
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
    const ramp = element("i", {
      class: "ramp",
      style: { background: `linear-gradient(to right, ${depth.colours.join(", ")})` },
    });
    key.append(element("span", {}, `depth ${short(depth.near)} m `, ramp, ` ${short(depth.far)} m`));
  }
  return key;
}
