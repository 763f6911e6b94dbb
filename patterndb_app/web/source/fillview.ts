/** The tab Fill: a boundary is drawn, fills of it stream in, one is shown on the stage. */

import { Group } from "three";
import { askOrders, type FillLine, ServiceError, streamFills } from "./api.ts";
import { ChoiceGroup, makeButton } from "./buttons.ts";
import { isEven, suggestEdge } from "./counts.ts";
import { announce, find, make, saveFile } from "./dom.ts";
import { dispose, makeFillFigure, makeLines, makeMarkers, makeSurface } from "./figure.ts";
import { FillCard } from "./fillcard.ts";
import { FillItem } from "./fillitem.ts";
import { FillPanel } from "./fillpanel.ts";
import { Gallery, stepByKey } from "./gallery.ts";
import { EXAMPLES, forgetExamples, type KnownGround, loadExample, PLANE, takeSurface } from "./grounds.ts";
import { LAYER } from "./materials.ts";
import { formatCount, formatPlural } from "./numbers.ts";
import { Overlay } from "./overlay.ts";
import { decodeQuestion, encodeQuestion, formatPlace, roundPoint } from "./permalink.ts";
import { Pointing, type Tool } from "./pointing.ts";
import { decodeOptions, DEFAULTS, encodeOptions, LISTED, makeBody, type Options } from "./question.ts";
import { makeNet } from "./quadnet.ts";
import { Stage } from "./scene.ts";
import { SHAPES, Sketch } from "./sketch.ts";
import { onTheme, type Palette, readPalette } from "./theme.ts";
import type { Point } from "./vectors.ts";

/** Fills that are compared at a time, the shown one included. */
const COMPARED = 4;

/** Pixels that the card of the shown fill takes at the right. */
const CARD_ROOM = 280;

const TOOLS: readonly { value: Tool; words: string; icon: "turn" | "corners" | "strand" | "loop"; hint: string }[] = [
  { value: "corners", words: "Draw", icon: "corners", hint: "click corners; click the first again to close (b)" },
  { value: "strand", words: "Strand", icon: "strand", hint: "draw a strand of quads across (s)" },
  { value: "loop", words: "Loop", icon: "loop", hint: "draw a ring of quads inside (o)" },
  { value: "turn", words: "Move", icon: "turn", hint: "turn, shift, zoom (v)" },
];

const HINTS: Readonly<Record<Tool, string>> = {
  corners: "Click corners, one after another. Click the first again, or press Enter, to close.",
  strand: "Draw a line from one side to another: fills will have a strand of quads along it.",
  loop: "Draw a ring inside: fills will have a loop of quads along it.",
  turn: "Drag to move the view, scroll or pinch to zoom. Drag corners to change the boundary.",
};

export class FillView {
  private readonly stage: Stage;
  private readonly sketch = new Sketch(PLANE.ground);
  private readonly panel: FillPanel;
  private readonly card: FillCard;
  private readonly gallery: Gallery;
  private readonly overlay: Overlay;
  private readonly pointing: Pointing;
  private readonly tools: ChoiceGroup;
  private readonly backdrop = new Group();
  private readonly drawn = new Group();
  private readonly status = find("fill-status");
  private readonly empty = find("fill-empty");
  private readonly hint = find("fill-hint");
  private known: KnownGround = PLANE;
  private options: Options = { ...DEFAULTS };
  private items: FillItem[] = [];
  private pins: FillItem[] = [];
  private chosen = -1;
  private wanted = 1;
  private limit = LISTED;
  private truncated = false;
  private complete = true;
  private comparing = false;
  private strands = true;
  private tool: Tool = "corners";
  private search: AbortController | null = null;
  private preview: Point | null = null;
  private inProgress: { points: readonly Point[]; loop: boolean } = { points: [], loop: false };

  constructor() {
    this.stage = new Stage(find<HTMLCanvasElement>("fill-canvas"));
    this.stage.common.add(this.backdrop, this.drawn);
    this.panel = new FillPanel(find("fill-panel"), this.sketch, {
      ground: (name) => void this.useExample(name),
      file: (file) => void this.openFile(file),
      count: (side, n) => this.setCount(side, n),
      counts: (counts) => this.setCounts(counts),
      edge: (length) => this.change(() => this.sketch.setEdge(length)),
      toggle: (corner) => this.change(() => this.sketch.toggleKind(corner)),
      removeStroke: (i) => this.change(() => this.sketch.strokes.splice(i, 1), true),
      options: (options) => this.setOptions(options),
    });
    this.card = new FillCard(find("fill-card"), {
      step: (by) => this.choose(this.chosen + by),
      pin: () => this.togglePin(),
      compare: () => this.setComparing(!this.comparing),
      strands: () => this.toggleStrands(),
      download: () => this.download(),
      link: () => void this.copyLink(),
    });
    this.gallery = new Gallery("fills, best first", "Fills appear here, best first.", (i) => this.choose(i));
    find("fill-strip").append(this.gallery.element);
    this.overlay = new Overlay(find("fill-overlay"), this.stage, this.sketch, {
      count: (side, n) => this.setCount(side, n),
      move: (corner, to, done) => this.moveCorner(corner, to, done),
      toggle: (corner) => this.change(() => this.sketch.toggleKind(corner)),
    });
    this.pointing = new Pointing(this.stage, this.sketch, {
      corner: (at) => this.addCorner(at),
      close: () => this.close(),
      preview: (at, closes) => this.showPreview(at, closes),
      drawing: (points, loop) => {
        this.inProgress = { points, loop };
        this.redraw();
      },
      stroke: (points, loop) => this.addStroke(points, loop),
    });
    this.tools = new ChoiceGroup("tool", "tools", TOOLS, (tool) => this.setTool(tool as Tool));
    const ghost = { shown: false, className: "choice" };
    find("fill-tools").append(
      this.tools.element,
      make(
        "div",
        { class: "tools" },
        makeButton("undo", "undo the last corner or stroke", () => this.undo(), ghost),
        makeButton("fit", "show all", () => this.fit(), ghost),
        makeButton("clear", "begin anew", () => this.clear(), ghost),
      ),
    );
    this.fillEmptyState();
    this.acceptDrops(find("panel-fill"));
    onTheme(() => this.restyle());
    this.panel.setGround("plane");
    this.setTool("corners");
    this.stage.lookAtPlane();
    this.redraw();
    this.stage.prepare(makeSample());
  }

  // What the reader sees: tab, keys, address.

  setShown(shown: boolean): void {
    this.stage.setDrawing(shown);
  }

  async start(values: URLSearchParams): Promise<void> {
    this.options = decodeOptions(decodeQuestion(values)?.options ?? {});
    void askOrders().then(
      (orders) => this.panel.showOptions(orders, this.options),
      (error: unknown) => this.tell(readMessage(error), true),
    );
    await this.restore(values);
  }

  /** Asks the question of an address. */
  async restore(values: URLSearchParams): Promise<void> {
    const question = decodeQuestion(values);
    if (!question) {
      this.tell("The link could not be read; draw a boundary instead.", true);
      return;
    }
    if (question.surface === "dropped" && this.known.ground.name !== "dropped") {
      this.tell("The link is about a surface from a file, which a link cannot hold: drop it here again.", true);
      return;
    }
    if (question.surface !== "dropped" && !(await this.useGround(question.surface))) return;
    if (!question.corners.length) return;
    this.wanted = question.rank;
    this.sketch.restore(question.corners, question.kinds, question.counts, question.strokes);
    this.afterClosing();
    this.fit();
  }

  handleKey(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey) {
      if (event.key.toLowerCase() === "z") {
        event.preventDefault();
        this.undo();
      }
      return;
    }
    const step = stepByKey(event.key, this.chosen, this.items.length);
    if (step !== null) {
      event.preventDefault();
      this.choose(step);
      return;
    }
    const actions: Readonly<Record<string, () => void>> = {
      b: () => this.setTool("corners"),
      s: () => this.setTool("strand"),
      o: () => this.setTool("loop"),
      v: () => this.setTool("turn"),
      p: () => this.togglePin(),
      c: () => this.setComparing(!this.comparing),
      t: () => this.toggleStrands(),
      d: () => this.download(),
      f: () => this.fit(),
      Enter: () => this.close(),
      Escape: () => this.escape(),
      Backspace: () => this.undo(),
    };
    actions[event.key]?.();
  }

  private keepAddress(): void {
    const { sketch } = this;
    const values = encodeQuestion({
      surface: this.known.ground.name,
      corners: sketch.corners,
      kinds: sketch.kinds,
      counts: sketch.counts,
      strokes: sketch.strokes,
      options: encodeOptions(this.options),
      rank: this.chosen + 1,
    });
    history.replaceState(null, "", formatPlace("fill", values));
  }

  // The ground.

  private async useExample(name: string): Promise<void> {
    if (!(await this.useGround(name))) return;
    this.clear();
    const { corners } = this.known;
    if (!corners.length) return;
    for (const corner of corners) this.sketch.addCorner(this.known.ground.project(corner));
    this.close();
  }

  private async useGround(name: string): Promise<boolean> {
    if (name === this.known.ground.name) return true;
    if (name === "plane") {
      this.setGround(PLANE);
      return true;
    }
    const title = EXAMPLES.find((e) => e.name === name)?.title ?? name;
    this.tell(`Loading ${title} …`);
    try {
      this.setGround(await loadExample(name));
      this.tell("");
      return true;
    } catch (error) {
      this.tell(readMessage(error), true);
      this.panel.setGround(this.known.ground.name);
      return false;
    }
  }

  private async openFile(file: File): Promise<void> {
    this.tell(`Reading ${file.name} …`);
    try {
      this.setGround(await takeSurface(await file.arrayBuffer(), file.name));
      this.clear();
      this.tell(`${file.name}: click corners on it.`);
    } catch (error) {
      this.tell(readMessage(error), true);
    }
  }

  private setGround(known: KnownGround): void {
    this.known = known;
    this.sketch.ground = known.ground;
    this.sketch.clear();
    this.dropFills();
    this.pins = [];
    this.comparing = false;
    this.panel.setGround(known.ground.name);
    this.restyle();
    this.look();
    this.setTool("corners");
  }

  private look(): void {
    const { ground, from } = this.known;
    if (!ground.geometry) {
      this.stage.lookAtPlane();
      return;
    }
    const place = ground.geometry.getAttribute("position");
    const points = Array.from({ length: place.count }, (_, i): Point => [place.getX(i), place.getY(i), place.getZ(i)]);
    this.stage.lookAtSurface(points, from);
  }

  private fit(): void {
    if (!this.sketch.closed) this.look();
    else if (this.known.ground.geometry) this.stage.frame(this.sketch.outline(), this.sketch.findNormal(), 1.9);
    else this.stage.frame(this.sketch.corners, [0, 0, 1], 1.32);
  }

  // The question.

  private addCorner(at: Point): void {
    if (this.sketch.closed) this.clear();
    this.sketch.addCorner(at);
    this.preview = null;
    this.empty.hidden = true;
    this.redraw();
    this.keepAddress();
  }

  private close(): void {
    if (this.sketch.closed || this.sketch.corners.length < 2) return;
    // The clock of "first fill on screen" starts with the last corner.
    performance.clearMarks("boundary-closed");
    performance.mark("boundary-closed");
    this.sketch.close();
    this.setTool("turn");
    this.afterClosing();
  }

  private afterClosing(): void {
    this.preview = null;
    this.empty.hidden = true;
    if (this.sketch.closed && this.tool === "corners") this.setTool("turn");
    this.ask();
    this.overlay.rebuild();
    this.panel.rebuild();
    this.redraw();
  }

  private change(edit: () => void, rebuild = false): void {
    edit();
    this.limit = LISTED;
    this.ask();
    if (rebuild) this.panel.rebuild();
    else this.panel.refresh();
    this.overlay.refresh();
    this.redraw();
  }

  private setCount(side: number, n: number): void {
    this.change(() => this.sketch.setCount(side, n));
  }

  private setCounts(counts: readonly number[]): void {
    this.change(() => counts.forEach((n, side) => this.sketch.setCount(side, n)));
  }

  private setOptions(options: Options): void {
    this.options = { ...options };
    this.change(() => undefined);
  }

  private moveCorner(corner: number, to: Point, done: boolean): void {
    this.sketch.moveCorner(corner, to);
    if (this.sketch.edge !== null) this.sketch.setEdge(suggestEdge(this.sketch.measureSides()));
    this.panel.refresh();
    this.overlay.refresh();
    // While it moves the boundary is shown alone: fills of the old one would not meet it.
    if (done) this.ask();
    else this.dropFills();
    this.redraw();
  }

  private addStroke(points: readonly Point[], loop: boolean): void {
    if (!this.sketch.closed) {
      this.tell("Draw the boundary first; strands run across it.", true);
      return;
    }
    this.change(() => this.sketch.strokes.push({ points: points.map(roundPoint), loop }), true);
  }

  private undo(): void {
    if (this.sketch.strokes.length) {
      this.change(() => this.sketch.strokes.pop(), true);
      return;
    }
    const corners = this.sketch.corners.slice(0, -1);
    this.clear();
    for (const corner of corners) this.sketch.addCorner(corner);
    this.empty.hidden = corners.length > 0;
    this.redraw();
  }

  private clear(): void {
    this.sketch.clear();
    this.limit = LISTED;
    this.dropFills();
    this.setComparing(false);
    this.overlay.rebuild();
    this.panel.rebuild();
    this.setTool("corners");
    this.empty.hidden = this.known.ground.geometry !== null;
    this.tell("");
    this.redraw();
    this.keepAddress();
  }

  private escape(): void {
    if (this.comparing) this.setComparing(false);
    else if (!this.sketch.closed && this.sketch.corners.length) this.clear();
    else this.setTool("turn");
  }

  private setTool(tool: Tool): void {
    this.tool = tool;
    this.tools.set(tool);
    this.pointing.setTool(tool);
    this.hint.textContent = HINTS[tool];
  }

  // The fills.

  private dropFills(): void {
    this.search?.abort();
    this.search = null;
    this.items = [];
    this.chosen = -1;
    this.gallery.clear();
    this.card.hide();
    this.showFigures();
  }

  private ask(): void {
    this.search?.abort();
    this.search = null;
    if (!this.sketch.closed) return;
    if (!isEven(this.sketch.counts)) {
      this.dropFills();
      this.tell("The number of edges around is odd: take one of the even ones that are offered.", true);
      this.keepAddress();
      return;
    }
    this.search = new AbortController();
    void this.collect(this.search.signal);
    this.tell("Searching …");
  }

  private async collect(signal: AbortSignal): Promise<void> {
    const kinds = [...this.sketch.kinds];
    const asked = this.wanted;
    const found: FillItem[] = [];
    let waiting = 0;
    // The old list stays until the new one has a fill, so that nothing flickers.
    const flush = (): void => {
      waiting = 0;
      if (signal.aborted) return;
      this.takeItems(found, asked);
    };
    try {
      const body = makeBody(this.sketch, this.options, this.known.id, this.limit);
      const stream = streamFills(body, signal);
      for (;;) {
        const next = await stream.next();
        if (signal.aborted) return;
        if (next.done) {
          if (waiting) clearTimeout(waiting);
          this.truncated = next.value.truncated;
          this.complete = next.value.complete ?? true;
          if (found.length) flush();
          else this.dropFills();
          this.tellEnd(next.value.seconds, next.value.reason ?? null);
          break;
        }
        found.push(new FillItem(next.value as FillLine, found.length + 1, kinds));
        if (found.length === 1) this.takeItems(found, asked);
        else if (!waiting) waiting = window.setTimeout(flush, 60);
      }
      this.wanted = 1;
    } catch (error) {
      if (signal.aborted) return;
      this.dropFills();
      if (error instanceof ServiceError && error.status === 404 && this.known.id) {
        forgetExamples();
        this.tell("The service has forgotten the surface; choose it again.", true);
      } else {
        this.tell(readMessage(error), true);
      }
    }
  }

  /** Shows what has been found so far: new pictures join the strip, the first fill the stage. */
  private takeItems(found: readonly FillItem[], wanted: number): void {
    const fresh = this.items[0] !== found[0];
    if (fresh) {
      this.items = [];
      this.chosen = -1;
      this.gallery.clear();
    }
    this.items = [...found];
    if (fresh) this.choose(0);
    const show = (): void => {
      const normal = this.sketch.findNormal();
      const up: Point = this.known.ground.geometry ? this.stage.up : [0, 1, 0];
      for (let i = this.gallery.length; i < this.items.length; i++) this.gallery.add(this.items[i]!.describe(normal, up));
      this.gallery.select(this.chosen);
    };
    if (fresh) {
      this.stage.afterPicture(() => {
        // The picture is on the screen when the browser asks for the next one.
        requestAnimationFrame(() => this.markFirst());
        show();
      });
    } else {
      show();
    }
    if (wanted > 1 && this.chosen === 0 && this.items.length >= wanted) this.choose(wanted - 1);
    else if (this.chosen >= 0) this.showCard();
  }

  /** Says to who measures that the first fill of a boundary is on the screen. */
  private markFirst(): void {
    if (!performance.getEntriesByName("boundary-closed").length) return;
    performance.measure("first-fill", "boundary-closed");
    performance.clearMarks("boundary-closed");
  }

  private tellEnd(seconds: number, reason: string | null): void {
    const count = this.items.length;
    if (!count) {
      this.tell(reason ?? "No fill was found; loosen a filter or take a strand away.", true);
      return;
    }
    const what = this.options.variants ? formatPlural(count, "fill") : formatPlural(count, "pattern");
    const cut = this.complete ? ", and there are more" : "; time was up, so that there may be more";
    const text = `${what}${this.truncated ? cut : ""} · ${Math.max(1, Math.round(seconds * 1000))} ms`;
    const more = this.truncated && makeButton(null, "More", () => this.askMore(), { className: "button ghost inline" });
    this.status.replaceChildren(text, ...(more ? [more] : []));
    this.status.classList.remove("error");
    announce(text);
  }

  private askMore(): void {
    this.limit *= 2;
    this.wanted = this.chosen + 1;
    this.ask();
  }

  private choose(index: number): void {
    if (index < 0 || index >= this.items.length || index === this.chosen) return;
    this.chosen = index;
    this.gallery.select(index);
    this.showFigures();
    this.showCard();
    this.keepAddress();
  }

  private get shown(): FillItem | undefined {
    return this.items[this.chosen];
  }

  private showCard(): void {
    const item = this.shown;
    if (!item) return;
    this.card.show(item, this.items.length, this.truncated);
    this.card.setState({
      pinned: this.pins.includes(item),
      pins: this.pins.length,
      comparing: this.comparing,
      strands: this.strands,
    });
    this.gallery.mark(new Set(this.pins.map((pin) => this.items.indexOf(pin))));
  }

  private showFigures(): void {
    const palette = readPalette();
    const item = this.shown;
    const others = this.comparing ? this.pins.filter((pin) => pin !== item) : [];
    const shown = [...(item ? [item] : []), ...others].slice(0, COMPARED);
    for (const old of [...this.figures]) dispose(old);
    this.figures = shown.map((one) => one.makeFigure(palette, this.strands));
    this.stage.show(this.figures, CARD_ROOM);
    this.drawLabels(this.comparing ? shown : []);
    this.redraw();
  }

  private figures: Group[] = [];

  private drawLabels(shown: readonly FillItem[]): void {
    const { viewports } = this.stage;
    find("fill-compared").replaceChildren(
      ...shown.map((item, i) => {
        const label = make(
          "div",
          { class: "compared" },
          make("b", {}, `${item === this.shown ? "" : "pinned "}${item.rank}`),
          ` ${item.line.quads.length} quads · ${item.valences.join("·") || "regular"} · ${formatCount(item.line.frequency)}×`,
        );
        const view = viewports[i]!;
        label.style.left = `${view.x * 100}%`;
        label.style.top = `${view.y * 100}%`;
        label.style.width = `${view.width * 100}%`;
        return label;
      }),
    );
  }

  private togglePin(): void {
    const item = this.shown;
    if (!item) return;
    const pinned = this.pins.includes(item);
    this.pins = pinned ? this.pins.filter((pin) => pin !== item) : [...this.pins, item].slice(-(COMPARED - 1));
    announce(pinned ? "unpinned" : `fill ${item.rank} pinned`);
    if (this.comparing) this.showFigures();
    this.showCard();
  }

  private setComparing(on: boolean): void {
    const next = on && this.pins.length > 0;
    if (next === this.comparing) return;
    this.comparing = next;
    this.showFigures();
    this.showCard();
  }

  private toggleStrands(): void {
    this.strands = !this.strands;
    this.showFigures();
    this.showCard();
  }

  private download(): void {
    const item = this.shown;
    if (item) saveFile(`fill-${item.rank}-${item.line.pattern}.obj`, item.formatObj());
  }

  private async copyLink(): Promise<void> {
    this.keepAddress();
    try {
      await navigator.clipboard.writeText(location.href);
      this.tell(this.known.ground.name === "dropped" ? "Link copied; it cannot hold the surface, which is dropped again." : "Link copied.");
    } catch {
      this.tell("The link is in the address bar: the browser lets no page copy it here.", true);
    }
  }

  // The picture.

  private restyle(): void {
    for (const old of [...this.backdrop.children]) dispose(old);
    const { geometry } = this.known.ground;
    // Geometry of a ground is kept: it is shown again.
    if (geometry) this.backdrop.add(makeSurface(geometry.clone(), readPalette()));
    else this.backdrop.add(drawGrid(readPalette()));
    this.showFigures();
  }

  /** Draws the boundary, strokes and what is in progress anew. */
  private redraw(): void {
    const palette = readPalette();
    const { sketch } = this;
    for (const old of [...this.drawn.children]) dispose(old);
    if (sketch.corners.length) {
      const sides = sketch.getSides();
      this.drawn.add(makeLines(sides, palette.boundary, 3, LAYER.boundary));
      const corners = sketch.corners.map((at, i) => ({
        at,
        colour: palette.boundary,
        sides: sketch.kinds[i] === "reflex" ? 4 : 0,
        radius: sketch.kinds[i] === "reflex" ? 6.5 : 5,
      }));
      this.drawn.add(makeMarkers(corners, palette.stage));
    }
    const last = sketch.corners.at(-1);
    if (this.preview && last && !sketch.closed) {
      this.drawn.add(makeLines([sketch.ground.trace(last, this.preview)], palette.selected, 2, LAYER.boundary));
    }
    for (const { points, loop } of sketch.strokes) this.drawStroke(points, loop, palette);
    if (this.inProgress.points.length > 1) this.drawStroke(this.inProgress.points, this.inProgress.loop, palette);
    this.stage.draw();
  }

  private drawStroke(points: readonly Point[], loop: boolean, palette: Palette): void {
    const closed = loop ? [...points, points[0]!] : points;
    const { ground } = this.sketch;
    const along = closed.flatMap((p, i) => {
      if (i === 0) return [p];
      const before = closed[i - 1]!;
      return ground.geometry ? ground.trace(before, p).slice(1) : [p];
    });
    this.drawn.add(makeLines([along], palette.stroke, 4, LAYER.stroke));
  }

  private showPreview(at: Point | null, closes: boolean): void {
    if (!this.sketch.corners.length || this.sketch.closed) return;
    this.preview = closes ? this.sketch.corners[0]! : at;
    this.redraw();
  }

  private tell(text: string, error = false): void {
    this.status.textContent = text;
    this.status.classList.toggle("error", error);
    if (error) announce(text);
  }

  // What is there before anything is drawn.

  private fillEmptyState(): void {
    const shapes = Object.values(SHAPES).map(({ title, corners }) =>
      makeButton(null, title, () => {
        this.clear();
        for (const corner of corners) this.sketch.addCorner(corner);
        this.close();
        this.fit();
      }, { className: "button" }),
    );
    find("fill-shapes").append(...shapes);
  }

  private acceptDrops(element: HTMLElement): void {
    element.addEventListener("dragover", (event) => {
      event.preventDefault();
      element.classList.add("dropping");
    });
    element.addEventListener("dragleave", () => element.classList.remove("dropping"));
    element.addEventListener("drop", (event) => {
      event.preventDefault();
      element.classList.remove("dropping");
      const file = event.dataTransfer?.files[0];
      if (file) void this.openFile(file);
    });
  }
}

/** A fill of one quad with a marker: all that a fill's picture is made of. */
function makeSample(): Group {
  const points: Point[] = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]];
  const asked = new Map([[1, 1], [2, 1], [3, 1]]);
  return makeFillFigure({ net: makeNet([[0, 1, 2, 3]], 4), points, asked }, readPalette(), true);
}

/** A faint grid under the plane, for the eye to rest on. */
function drawGrid(palette: Palette): ReturnType<typeof makeLines> {
  const lines: Point[][] = [];
  for (let i = -24; i <= 24; i++) {
    lines.push([[i / 4, -6, -0.001], [i / 4, 6, -0.001]], [[-6, i / 4, -0.001], [6, i / 4, -0.001]]);
  }
  return makeLines(lines, palette.grid, 1, LAYER.surface);
}

export const readMessage = (error: unknown): string => (error instanceof Error ? error.message : String(error));
