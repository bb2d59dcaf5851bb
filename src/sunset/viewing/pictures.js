// Pictures: unpacked when they are needed, kept for a while, and drawn on canvases.

/** Make an element with attributes and children; a text among them stays a text, whatever it says. */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "style") Object.assign(made.style, value);
    else if (value !== undefined && value !== false) made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

/** How a run is called: by its managing system, and by a letter where there are two. */
function nameOf(run) {
  return page.runs.length > 1 ? `${"AB"[page.runs.indexOf(run)]}: ${run.manager}` : run.manager;
}

/** The place of the last number that is at most a value, in an ascending list; -1 if there is none. */
function lastAtMost(numbers, value) {
  let low = 0;
  let high = numbers.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (numbers[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

const KEPT_BYTES = 8e7;

/** All pictures of the page, by their place; those that were asked for last are kept. */
class Pictures {
  constructor(view) {
    this.view = view;
    this.kept = new Map();
    this.most = Math.max(64, Math.round(KEPT_BYTES / (4 * view.width * view.height + 1)));
  }

  /** Promise an ImageBitmap. */
  bitmap(place) {
    return this.keep(place, (bytes) => createImageBitmap(new Blob([bytes], { type: "image/webp" })));
  }

  /** Promise the class index of every pixel. */
  labels(place) {
    return this.keep(place, (bytes) => this.unpack(bytes));
  }

  keep(place, decode) {
    const found = this.kept.get(place) ?? decode(this.bytes(place));
    this.kept.delete(place);
    this.kept.set(place, found); // as the newest
    if (this.kept.size > this.most) this.kept.delete(this.kept.keys().next().value);
    return found;
  }

  bytes(place) {
    return Uint8Array.from(atob(this.view.data[place]), (character) => character.charCodeAt(0));
  }

  /** See labels.py: the values of all runs of pixels, the low bytes of their lengths, the high ones. */
  async unpack(bytes) {
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    const runs = new Uint8Array(await new Response(stream).arrayBuffer());
    const count = runs.length / 3;
    const labels = new Uint8Array(this.view.width * this.view.height);
    let at = 0;
    for (let run = 0; run < count; run++) {
      const length = runs[count + run] + 256 * runs[2 * count + run];
      labels.fill(runs[run], at, at + length);
      at += length;
    }
    return labels;
  }
}

const WRONG = [255, 150, 40];

/** The colours of class indices as canvases have them: [red, green, blue] by index; none where it is no class. */
function paletteOf(classes) {
  return classes.map(({ colour }) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16)));
}

/** One picture of every frame of a run, with its title and what is said of it now. */
class PanelView {
  constructor(panel, run, page, pictures) {
    Object.assign(this, { panel, run, page, pictures });
    this.palette = paletteOf(page.classes);
    const { width, height } = pictures.view;
    this.canvas = element("canvas", { width, height, role: "img", "aria-label": panel.title });
    this.context = this.canvas.getContext("2d");
    this.cross = element("i", { class: "cross" });
    this.missing = element("span", { class: "missing" });
    this.state = element("span", { class: "state" });
    this.picture = element("div", { class: "picture" }, this.canvas, this.cross, this.missing);
    this.figure = element(
      "figure",
      { class: `panel ${panel.kind}`, title: panel.explanation, "data-panel": panel.name },
      this.picture,
      element("figcaption", {}, element("b", {}, panel.title), this.state),
    );
  }

  /** The pictures of the labels and the truth, which the difference is made of. */
  get pair() {
    const named = (name) => this.run.frames.panels.find((panel) => panel.name === name).pictures;
    return [named("labels"), named("truth")];
  }

  isThere(frame) {
    const has = (places) => frame >= 0 && (places[frame] ?? -1) >= 0;
    if (this.panel.kind === "difference") return this.pair.every(has);
    return has(this.panel.pictures) || has(this.panel.beside);
  }

  /** Promise a function that draws a frame, so that all pictures of a moment are drawn at once. */
  async load(frame) {
    if (!this.isThere(frame)) return () => this.clear(frame);
    const { kind, pictures, beside } = this.panel;
    if (kind === "labels") {
      const labels = await this.pictures.labels(pictures[frame]);
      return () => this.drawLabels((index) => this.palette[labels[index]]);
    }
    if (kind === "difference") {
      const [labels, truth] = await Promise.all(
        this.pair.map((places) => this.pictures.labels(places[frame])),
      );
      return () => this.drawDifference(labels, truth, frame);
    }
    const places = [pictures[frame] ?? -1, beside[frame] ?? -1].filter((place) => place >= 0);
    const bitmaps = await Promise.all(places.map((place) => this.pictures.bitmap(place)));
    return () => this.drawBitmaps(bitmaps, frame);
  }

  clear(frame) {
    const { width, height } = this.canvas;
    this.context.clearRect(0, 0, width, height);
    const { times } = this.run.frames;
    let last = frame;
    while (last >= 0 && !this.isThere(last)) last--;
    const lasted = last >= 0 ? ` for ${(times[frame] - times[last]).toFixed(1)} s` : "";
    this.missing.textContent = `no image${lasted}`;
    this.figure.classList.add("gone");
    this.state.textContent = "";
  }

  show() {
    this.figure.classList.remove("gone");
    this.missing.textContent = "";
  }

  drawBitmaps(bitmaps, frame) {
    this.show();
    const { width, height } = this.canvas;
    this.context.drawImage(bitmaps[0], 0, 0, width, height);
    if (bitmaps.length > 1) {
      const [w, h] = [width * 0.36, height * 0.36];
      this.context.fillStyle = "#fff";
      this.context.fillRect(width - w - 2, height - h - 2, w + 2, h + 2);
      this.context.drawImage(bitmaps[1], width - w, height - h, w, h);
    }
    if (this.panel.kind === "given") {
      const only = this.panel.pictures[frame] >= 0 ? "colour only" : "depth only";
      this.state.textContent = bitmaps.length > 1 ? "with depth" : only;
    }
  }

  /** Draw what a function says of every pixel: [red, green, blue], or nothing where there is no class. */
  drawLabels(colourOf) {
    this.show();
    const { width, height } = this.canvas;
    const image = this.context.createImageData(width, height);
    for (let index = 0; index < width * height; index++) {
      const colour = colourOf(index);
      if (colour) image.data.set([colour[0], colour[1], colour[2], 255], 4 * index);
    }
    this.context.putImageData(image, 0, 0);
  }

  drawDifference(labels, truth, frame) {
    let wrong = 0;
    let judged = 0;
    this.drawLabels((index) => {
      const colour = this.palette[truth[index]];
      if (!colour) return undefined;
      judged++;
      if (labels[index] !== truth[index]) {
        wrong++;
        return WRONG;
      }
      const gray = 30 + 0.3 * (0.3 * colour[0] + 0.6 * colour[1] + 0.1 * colour[2]);
      return [gray, gray, gray];
    });
    const iou = this.run.frames.iou[frame];
    const right = judged ? `${Math.round(100 * (1 - wrong / judged))} % right` : "";
    this.state.textContent = `${iou === null ? "" : `IoU ${iou.toFixed(2)}, `}${right}`;
  }

  /** Show which pixel is pointed at, at a share of width and height; nothing hides it. */
  point(at) {
    this.cross.style.display = at ? "block" : "none";
    if (at) Object.assign(this.cross.style, { left: `${100 * at.x}%`, top: `${100 * at.y}%` });
  }

  /** Promise the name of the class of a pixel of a frame. */
  async className(frame, at) {
    if (!this.isThere(frame)) return "–";
    const { width, height } = this.canvas;
    const labels = await this.pictures.labels(this.panel.pictures[frame]);
    const index = Math.floor(at.y * height) * width + Math.floor(at.x * width);
    return this.page.classes[labels[index]]?.name ?? "no class";
  }
}
