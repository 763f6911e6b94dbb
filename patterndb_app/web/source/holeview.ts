/** The tab Hole: a mesh with holes, its loops, the fills of one, welded. */

import { Group } from "three";
import { askHoleFills, askLoops, askShapes, type HoleFillLine, type HoleLoop, type ShapeInfo } from "./api.ts";
import { makeButton } from "./buttons.ts";
import { announce, find, make, saveFile } from "./dom.ts";
import { dispose, makeFillFigure, makeGeometry, makeLines, makeMarkers, makeMeshEdges, makeSurface } from "./figure.ts";
import { makeMeasureField, makeRow, makeSelect } from "./fields.ts";
import { section } from "./fillpanel.ts";
import { readMessage } from "./fillview.ts";
import { Gallery, stepByKey } from "./gallery.ts";
import { LAYER } from "./materials.ts";
import { formatObj, parseMesh, type PolygonMesh, weldFill } from "./meshfile.ts";
import { formatCount, formatMeasure, formatPlural, parseNumber } from "./numbers.ts";
import { formatPlace } from "./permalink.ts";
import { makeNet, type QuadNet } from "./quadnet.ts";
import { Stage } from "./scene.ts";
import { chooseValenceColour, onTheme, readPalette } from "./theme.ts";
import { drawKey, drawThumbnail, flatten } from "./thumbnail.ts";
import { add, measureArea, normalize, type Point, scale } from "./vectors.ts";

/** Fills of a hole that are asked for. */
const LISTED = 16;

/** Pixels within which a click means a loop. */
const NEAR = 16;

const EXAMPLE = { name: "head-holes", title: "Head with a hole on the nose", from: [0.75, 0.1, 1] as Point };

/** A fill of a hole, numbered anew: vertices of its quads only. */
interface HoleItem {
  readonly line: HoleFillLine;
  readonly net: QuadNet;
  readonly points: readonly Point[];
  /** Quads and other faces around each of its vertices in the whole mesh; 0 on a border. */
  readonly valences: readonly number[];
  readonly asked: ReadonlyMap<number, number>;
}

export class HoleView {
  private readonly stage = new Stage(find<HTMLCanvasElement>("hole-canvas"));
  private readonly gallery = new Gallery("fills of the hole, best first", "Fills of a hole appear here, best first.", (i) => this.choose(i));
  private readonly status = find("hole-status");
  private readonly card = find("hole-card");
  private readonly loopList = make("div", { class: "loops", role: "radiogroup", "aria-label": "holes", "data-keys": true });
  /** How fills are to lie: choices that the service lists. */
  private readonly choices = make("div", {}, make("p", { class: "hint" }, "The service has not listed its shapes yet."));
  private shapes: ShapeInfo | null = null;
  private shape: string | null = null;
  private tension: number | null = null;
  private readonly base = new Group();
  private readonly rims = new Group();
  private figure: Group | null = null;
  private mesh: PolygonMesh | null = null;
  private name = "";
  private loops: readonly HoleLoop[] = [];
  private open = -1;
  private items: HoleItem[] = [];
  private chosen = -1;
  private search: AbortController | null = null;

  constructor() {
    this.stage.common.add(this.base, this.rims);
    find("hole-strip").append(this.gallery.element);
    const file = make("input", { type: "file", accept: ".obj,.ply", id: "hole-file", class: "unseen", tabindex: -1, "aria-label": "mesh file" });
    file.addEventListener("change", () => {
      if (file.files?.[0]) void this.openFile(file.files[0]);
      file.value = "";
    });
    const pick = (): void => file.click();
    find("hole-panel").append(
      section("Mesh", makeButton("open", "Open or drop OBJ, PLY", pick, { className: "button quiet wide" }), makeButton(null, EXAMPLE.title, () => void this.openExample(), { className: "button quiet wide" }), file),
      section("Holes", this.loopList),
      section("How fills lie", this.choices),
    );
    find("hole-begin").append(makeButton("open", "Open a mesh", pick, { className: "button primary" }), makeButton(null, EXAMPLE.title, () => void this.openExample()));
    this.card.hidden = true;
    this.listLoops();
    this.acceptDrops(find("panel-hole"));
    this.acceptClicks();
    onTheme(() => this.restyle());
  }

  setShown(shown: boolean): void {
    this.stage.setDrawing(shown);
  }

  private async loadShapes(): Promise<void> {
    try {
      this.shapes = await askShapes();
      this.showChoices(this.shapes);
    } catch (error) {
      this.tell(readMessage(error), true);
    }
  }

  /** Makes the choices of shape and tension. */
  private showChoices({ shapes, tension }: ShapeInfo): void {
    const what = make("p", { class: "hint", id: "hole-shape-help" });
    const names = shapes.map(({ name }): [string, string] => [name, name]);
    const shape = makeSelect("hole-shape", names, this.shape ?? names[0]![0], (name) => {
      this.shape = name;
      describe();
      refill();
    });
    shape.setAttribute("aria-describedby", "hole-shape-help");
    const field = makeMeasureField(
      "hole-tension",
      String(tension[0]),
      (value) => {
        this.tension = value;
        refill();
      },
      (value) => value >= tension[0] && value <= tension[1],
    );
    field.set(this.tension);
    field.element.title = `${tension[0]}: bends least, ${tension[1]}: a membrane`;
    const describe = (): void => {
      what.textContent = `${shape.value}: ${shapes.find(({ name }) => name === shape.value)?.what ?? "unknown"}.`;
      field.element.disabled = shape.value === "flat";
    };
    const refill = (): void => {
      this.keepAddress();
      if (this.open >= 0) void this.fill(this.open);
    };
    describe();
    this.choices.replaceChildren(makeRow("Shape", shape, "hole-shape"), what, makeRow("Tension", field.element, "hole-tension"));
  }

  /** The entries of a question that say how its fills are to lie. */
  private listChoices(): Record<string, string | number> {
    return {
      ...(this.shape !== null && { shape: this.shape }),
      ...(this.tension !== null && this.shape !== "flat" && { tension: this.tension }),
    };
  }

  async show(values: URLSearchParams): Promise<void> {
    if (values.has("shape")) this.shape = values.get("shape");
    if (values.has("tension")) this.tension = parseNumber(values.get("tension")!);
    if (this.shapes) this.showChoices(this.shapes);
    else void this.loadShapes();
    if (values.get("mesh") !== EXAMPLE.name || this.name === EXAMPLE.name) return;
    await this.openExample();
    const vertex = Number(values.get("loop"));
    const at = this.loops.findIndex((loop) => loop.loop.includes(vertex));
    if (values.has("loop") && at >= 0) await this.fill(at, Number(values.get("r") ?? 1));
  }

  handleKey(event: KeyboardEvent): void {
    const step = stepByKey(event.key, this.chosen, this.items.length);
    if (step !== null) {
      event.preventDefault();
      this.choose(step);
    } else if (event.key === "d" && !event.ctrlKey && !event.metaKey) {
      this.download();
    } else if (event.key === "Escape") {
      this.closeHole();
    }
  }

  private async openExample(): Promise<void> {
    const answer = await fetch(`page/examples/${EXAMPLE.name}.obj`);
    if (!answer.ok) this.tell("the example could not be loaded", true);
    else await this.take(await answer.arrayBuffer(), EXAMPLE.name, EXAMPLE.from);
  }

  private async openFile(file: File): Promise<void> {
    await this.take(await file.arrayBuffer(), file.name, [0.4, 0.3, 1]);
  }

  private async take(data: ArrayBuffer, name: string, from: Point): Promise<void> {
    this.closeHole();
    try {
      this.mesh = parseMesh(data, name);
      this.name = name;
      this.loops = [];
      this.listLoops();
      find("hole-empty").hidden = true;
      this.restyle();
      this.stage.lookAtSurface(this.mesh.points, from);
      this.tell("Looking for holes …");
      this.loops = await askLoops(this.mesh);
      this.tell(
        this.loops.length
          ? `${formatPlural(this.loops.length, "border loop")}: click the one to fill.`
          : "The mesh is closed: it has no hole.",
      );
    } catch (error) {
      this.tell(readMessage(error), true);
    }
    this.listLoops();
    this.restyle();
    this.keepAddress();
  }

  private listLoops(): void {
    const rows = this.loops.map((loop, i) =>
      make(
        "button",
        {
          type: "button",
          role: "radio",
          class: "loop-row",
          "aria-checked": String(i === this.open),
          onclick: () => void this.fill(i),
        },
        make("span", {}, formatPlural(loop.edges, "edge")),
        make("span", { class: "option-detail" }, `at vertex ${loop.loop[0]}, ${formatMeasure(loop.length)} around`),
      ),
    );
    const hint = make("p", { class: "hint" }, this.mesh ? "No hole is known yet." : "Open a mesh to see its holes.");
    this.loopList.replaceChildren(...(rows.length ? rows : [hint]));
  }

  /** Asks for the fills of a hole and shows them. */
  private async fill(index: number, rank = 1): Promise<void> {
    const loop = this.loops[index];
    if (!this.mesh || !loop) return;
    this.closeHole();
    this.open = index;
    this.listLoops();
    this.restyle();
    this.frameLoop(loop);
    this.search = new AbortController();
    const { signal } = this.search;
    this.tell(`Filling the hole of ${loop.edges} edges …`);
    try {
      const answer = await askHoleFills(this.mesh, loop.loop[0]!, LISTED, this.listChoices(), signal);
      if (signal.aborted) return;
      this.items = answer.fills.map((line) => this.makeItem(line));
      for (const [i, item] of this.items.entries()) this.addToGallery(item, i, loop);
      this.tell(`${formatPlural(this.items.length, "fill")} · ${Math.max(1, Math.round(answer.seconds * 1000))} ms`);
      announce(`${formatPlural(this.items.length, "fill")} of the hole`);
      this.choose(Math.min(this.items.length, Math.max(1, rank)) - 1);
    } catch (error) {
      if (!signal.aborted) this.tell(readMessage(error), true);
    }
  }

  private closeHole(): void {
    this.search?.abort();
    this.open = -1;
    this.items = [];
    this.chosen = -1;
    this.gallery.clear();
    this.card.hidden = true;
    this.showFigure();
    this.listLoops();
    this.restyle();
  }

  private makeItem(line: HoleFillLine): HoleItem {
    const mesh = this.mesh!;
    const used = [...new Set(line.quads.flat())].sort((a, b) => a - b);
    const number = new Map(used.map((v, i) => [v, i]));
    const n = mesh.points.length;
    const points = used.map((v) => (v < n ? mesh.points[v]! : line.points[v - n]!));
    const quads = line.quads.map((quad) => quad.map((v) => number.get(v)!));
    const net = makeNet(quads, used.length);
    const valences = [...net.valences];
    for (const face of mesh.faces) {
      for (const v of face) {
        const i = number.get(v);
        if (i !== undefined) valences[i]!++;
      }
    }
    // On the rim a vertex is irregular where the faces around it, old and new, are not four.
    const asked = new Map<number, number>();
    net.edges.forEach((edge, i) => {
      if (net.onBorder[i]) for (const v of edge) asked.set(v, net.valences[v]!);
    });
    return { line, net, points, valences, asked };
  }

  private listValences(item: HoleItem): number[] {
    return item.valences.filter((v) => v !== 4).sort((a, b) => a - b);
  }

  private addToGallery(item: HoleItem, index: number, loop: HoleLoop): void {
    const normal = this.findNormal(loop);
    const twin = item.line.origin === "twin";
    this.gallery.add({
      picture: drawThumbnail({ net: item.net, places: flatten(item.points, normal, [0, 1, 0]), asked: item.asked }),
      title: String(index + 1),
      detail: twin ? "mirror twin" : `${item.line.quads.length} quads`,
      label: `fill ${index + 1}, ${formatPlural(item.line.quads.length, "quad")}, ${formatPlural(item.line.n_irregular, "irregular vertex", "irregular vertices")}`,
    });
  }

  /** Out of the hole: its rim runs with the mesh on the one side or the other. */
  private findNormal(loop: HoleLoop): Point {
    const rim = loop.loop.map((v) => this.mesh!.points[v]!);
    const normal = normalize(measureArea(rim));
    const next = new Set(loop.loop.map((v, i) => `${v},${loop.loop[(i + 1) % loop.loop.length]}`));
    const along = this.mesh!.faces.some((face) => face.some((v, i) => next.has(`${v},${face[(i + 1) % face.length]}`)));
    return along ? scale(normal, -1) : normal;
  }

  private frameLoop(loop: HoleLoop): void {
    const rim = loop.loop.map((v) => this.mesh!.points[v]!);
    // A little from above, so that the fill's shape is seen.
    this.stage.frame(rim, add(this.findNormal(loop), [0.25, 0.2, 0.1]), 2.4);
  }

  private choose(index: number): void {
    if (index < 0 || index >= this.items.length) return;
    this.chosen = index;
    this.gallery.select(index);
    this.showFigure();
    this.showCard();
    this.keepAddress();
  }

  private showCard(): void {
    const item = this.items[this.chosen]!;
    const { line } = item;
    const valences = this.listValences(item);
    const facts: [string, Node | string][] = [
      ["pattern", line.origin === "twin" ? "the other side, mirrored" : make("a", { href: `#patterns?id=${line.pattern}`, class: "mono" }, line.pattern)],
      ["origin", line.origin],
      ["quads", formatCount(line.quads.length)],
      ["irregular", valences.length ? make("span", { class: "keys" }, ...drawKey(valences)) : "none"],
    ];
    if (line.score !== null) facts.push(["score", formatMeasure(line.score)]);
    if (line.flat) facts.push(["shape", "flat"]);
    if (line.flipped) facts.push(["flipped", formatCount(line.flipped)]);
    const ghost = { shown: false, className: "button ghost" };
    this.card.replaceChildren(
      make(
        "div",
        { class: "card-head" },
        make("h2", { class: "card-title" }, `Fill ${this.chosen + 1} of ${this.items.length}`),
        makeButton("back", "previous fill", () => this.choose(this.chosen - 1), ghost),
        makeButton("next", "next fill", () => this.choose(this.chosen + 1), ghost),
      ),
      make("dl", { class: "facts" }, ...facts.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)])),
      makeButton("download", "Download the mesh", () => this.download(), { className: "button primary wide", hint: "the whole mesh, filled, as OBJ (d)" }),
    );
    this.card.hidden = false;
  }

  private download(): void {
    const item = this.items[this.chosen];
    if (!item || !this.mesh) return;
    const welded = weldFill(this.mesh, item.line.quads, item.line.points);
    saveFile(`${this.name.replace(/\.[a-z]+$/i, "")}-filled.obj`, formatObj(welded, [`filled by patterndb, pattern ${item.line.pattern}`]));
  }

  private keepAddress(): void {
    const values = new URLSearchParams();
    if (this.name === EXAMPLE.name) {
      values.set("mesh", this.name);
      const loop = this.loops[this.open];
      if (loop) values.set("loop", String(loop.loop[0]));
      if (this.chosen > 0) values.set("r", String(this.chosen + 1));
      for (const [name, value] of Object.entries(this.listChoices())) values.set(name, String(value));
    }
    history.replaceState(null, "", formatPlace("hole", values));
  }

  private showFigure(): void {
    if (this.figure) dispose(this.figure);
    this.figure = null;
    const item = this.items[this.chosen];
    if (item) {
      const palette = readPalette();
      const filled = { ...palette, quad: palette.filled, edge: palette.filledEdge, boundary: palette.selected };
      this.figure = makeFillFigure({ ...item, asked: item.asked }, filled, false);
      const odd = item.valences.flatMap((valence, i) => {
        const inside = !item.asked.has(i);
        // Those inside are marked already; 4 faces are regular on the rim, too.
        return valence === 4 || inside ? [] : [{ at: item.points[i]!, colour: chooseValenceColour(valence), sides: valence, radius: 6.5 }];
      });
      this.figure.add(makeMarkers(odd, palette.rim));
    }
    this.stage.show(this.figure ? [this.figure] : []);
  }

  private restyle(): void {
    for (const group of [this.base, this.rims]) for (const old of [...group.children]) dispose(old);
    const { mesh } = this;
    if (mesh) {
      const palette = readPalette();
      this.base.add(makeSurface(makeGeometry(mesh), palette), makeMeshEdges(mesh, palette.surfaceEdge, 1, LAYER.mesh));
      this.loops.forEach(({ loop }, i) => {
        const rim = [...loop, loop[0]!].map((v) => mesh.points[v]!);
        this.rims.add(makeLines([rim], i === this.open ? palette.selected : palette.loop, i === this.open ? 4 : 5, LAYER.boundary));
      });
    }
    this.showFigure();
    this.stage.draw();
  }

  /** A click near a rim fills its hole. */
  private acceptClicks(): void {
    const { canvas } = this.stage;
    let down: { x: number; y: number } | null = null;
    const find = (event: PointerEvent): number => {
      const box = canvas.getBoundingClientRect();
      const [x, y] = [event.clientX - box.left, event.clientY - box.top];
      let best = -1;
      let nearest = event.pointerType === "touch" ? NEAR * 1.8 : NEAR;
      this.loops.forEach(({ loop }, i) => {
        const seen = loop.map((v) => this.stage.project(this.mesh!.points[v]!));
        seen.forEach((a, k) => {
          const away = measureToSegment([x, y], a, seen[(k + 1) % seen.length]!);
          if (away < nearest) [nearest, best] = [away, i];
        });
      });
      return best;
    };
    canvas.addEventListener("pointerdown", (event) => (down = { x: event.clientX, y: event.clientY }));
    canvas.addEventListener("pointermove", (event) => {
      if (!event.buttons) canvas.classList.toggle("near", find(event) >= 0);
    });
    canvas.addEventListener("pointerup", (event) => {
      if (!down || Math.hypot(event.clientX - down.x, event.clientY - down.y) > 6) return;
      const loop = find(event);
      if (loop >= 0 && loop !== this.open) void this.fill(loop);
    });
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

  private tell(text: string, error = false): void {
    this.status.textContent = text;
    this.status.classList.toggle("error", error);
    if (error) announce(text);
  }
}

function measureToSegment([x, y]: readonly [number, number], a: { x: number; y: number }, b: { x: number; y: number }): number {
  const [dx, dy] = [b.x - a.x, b.y - a.y];
  const size = dx * dx + dy * dy;
  const t = size > 0 ? Math.min(1, Math.max(0, ((x - a.x) * dx + (y - a.y) * dy) / size)) : 0;
  return Math.hypot(x - a.x - t * dx, y - a.y - t * dy);
}
