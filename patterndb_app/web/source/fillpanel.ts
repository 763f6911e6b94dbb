/** The form beside the canvas: what is drawn on, the sides, strands, and which fills. */

import { ChoiceGroup, makeButton } from "./buttons.ts";
import { offerEven, sum } from "./counts.ts";
import { make } from "./dom.ts";
import { makeCountField, makeMeasureField, makeRow, makeSelect, makeSwitch, type MeasureField } from "./fields.ts";
import { EXAMPLES } from "./grounds.ts";
import { formatPlural } from "./numbers.ts";
import type { OrderInfo } from "./api.ts";
import type { Options } from "./question.ts";
import type { Sketch } from "./sketch.ts";

export interface PanelActions {
  ground(name: string): void;
  file(file: File): void;
  count(side: number, value: number): void;
  counts(counts: readonly number[]): void;
  edge(length: number): void;
  toggle(corner: number): void;
  removeStroke(index: number): void;
  options(options: Options): void;
}

export class FillPanel {
  private readonly grounds: ChoiceGroup;
  private readonly sides = make("div", { class: "sides" });
  private readonly parity = make("div", { class: "parity", role: "status" });
  private readonly strokes = make("div", { class: "strokes" });
  private readonly which = make("div", { class: "section-body" });
  private readonly edge: MeasureField;
  private fields: ReturnType<typeof makeCountField>[] = [];

  constructor(
    element: HTMLElement,
    private readonly sketch: Sketch,
    private readonly actions: PanelActions,
  ) {
    const surfaces = EXAMPLES.map(({ name, title }) => ({ value: name, words: title }));
    this.grounds = new ChoiceGroup("draw on", "segments", [{ value: "plane", words: "Plane" }, ...surfaces], (name) =>
      actions.ground(name),
    );
    const file = make("input", { type: "file", accept: ".obj,.ply", id: "surface-file", class: "unseen", tabindex: -1, "aria-label": "surface file" });
    file.addEventListener("change", () => {
      if (file.files?.[0]) actions.file(file.files[0]);
      file.value = "";
    });
    this.edge = makeMeasureField(
      "edge-length",
      "",
      (value) => value !== null && actions.edge(value),
      (value) => value > 0,
    );
    element.append(
      section("Draw on", this.grounds.element, makeButton("open", "Open or drop OBJ, PLY", () => file.click(), { className: "button quiet wide" }), file),
      section("Sides", this.sides, makeRow("Edge length", this.edge.element, "edge-length"), this.parity),
      section("Strands", this.strokes),
      section("Which fills", this.which),
    );
    this.rebuild();
  }

  setGround(name: string): void {
    this.grounds.set(name);
  }

  /** Makes the rows anew: another polygon, other strokes. */
  rebuild(): void {
    const { sketch, actions } = this;
    this.fields = sketch.counts.map((count, side) =>
      makeCountField(`edges of side ${side + 1}, in the list`, count, (n) => actions.count(side, n)),
    );
    const rows = this.fields.map((field, i) =>
      make(
        "div",
        { class: "side-row" },
        make("span", { class: "side-name" }, `Side ${i + 1}`),
        field.element,
        make("button", { type: "button", class: "kind", onclick: () => actions.toggle(i) }),
      ),
    );
    const hint = make("p", { class: "hint" }, "Draw a polygon: every side gets a number of edges here.");
    this.sides.replaceChildren(...(rows.length ? rows : [hint]));
    const strokes = sketch.strokes.map((stroke, i) =>
      make(
        "div",
        { class: "stroke-row" },
        make("span", { class: stroke.loop ? "swatch loop" : "swatch" }),
        make("span", {}, stroke.loop ? "Loop" : "Strand across"),
        makeButton("close", `remove ${stroke.loop ? "loop" : "strand"} ${i + 1}`, () => actions.removeStroke(i), { shown: false, className: "button ghost" }),
      ),
    );
    const told = make("p", { class: "hint" }, "Draw a line across to ask for a strand of quads there, or a loop.");
    this.strokes.replaceChildren(...(strokes.length ? strokes : [told]));
    this.refresh();
  }

  /** Shows counts, kinds and parity as they are now. */
  refresh(): void {
    const { sketch } = this;
    this.fields.forEach((field, i) => field.set(sketch.counts[i]!));
    this.sides.querySelectorAll<HTMLElement>(".kind").forEach((button, i) => {
      const kind = sketch.kinds[i]!;
      button.textContent = kind;
      button.classList.toggle("reflex", kind === "reflex");
      button.setAttribute("aria-label", `corner ${i + 1} is ${kind}; change it`);
    });
    this.edge.element.disabled = !sketch.closed;
    this.edge.set(sketch.closed ? (sketch.edge ?? sketch.edgeLength) : null);
    this.showParity();
  }

  private showParity(): void {
    const { sketch, actions } = this;
    const offers = sketch.closed ? offerEven(sketch.counts, sketch.measureSides()) : [];
    const perimeter = sum(sketch.counts);
    if (!sketch.closed) {
      this.parity.replaceChildren();
    } else if (!offers.length) {
      this.parity.replaceChildren(
        make("p", { class: "hint" }, `${formatPlural(perimeter, "edge")} around`),
      );
    } else {
      const buttons = offers.map((offer) => {
        const from = sketch.counts[offer.side]!;
        return make(
          "button",
          {
            type: "button",
            class: "offer",
            "aria-label": `side ${offer.side + 1} from ${from} to ${from + offer.step}`,
            onclick: () => actions.counts(offer.counts),
          },
          `Side ${offer.side + 1}: ${from} → ${from + offer.step}`,
        );
      });
      this.parity.replaceChildren(
        make("p", { class: "warning" }, `${perimeter} edges around is odd, and no quad mesh has an odd boundary. Nearest even ones:`),
        make("div", { class: "offers" }, ...buttons),
      );
    }
  }

  /** Makes the choices of order and filters, once the service has told its orders. */
  showOptions(orders: readonly OrderInfo[], options: Options): void {
    const change = (part: Partial<Options>): void => {
      Object.assign(options, part);
      this.actions.options(options);
    };
    const names = orders.map((o): [string, string] => [o.name, o.name]);
    const order = makeSelect("order", names, options.order, (value) => change({ order: value }));
    const told = make("p", { class: "hint", id: "order-help" });
    const tell = (): void => {
      const first = orders.find((o) => o.name === order.value)?.first;
      told.textContent = first ? `First: ${first}.` : "";
      told.hidden = !first;
    };
    order.setAttribute("aria-describedby", "order-help");
    order.addEventListener("change", tell);
    tell();
    const most = makeMeasureField(
      "max-irregular",
      "any",
      (value) => change({ maxIrregular: value }),
      (value) => Number.isInteger(value) && value >= 0,
    );
    most.set(options.maxIrregular);
    this.which.replaceChildren(
      makeRow("Order", order, "order"),
      told,
      makeRow("Max. irregular", most.element, "max-irregular"),
      makeSwitch("strict", "Corners exactly as drawn", options.strict, (strict) => change({ strict })),
      makeSwitch("variants", "All variants of each pattern", options.variants, (variants) => change({ variants })),
    );
  }
}

export function section(title: string, ...children: (Node | string)[]): HTMLElement {
  return make("section", { class: "section" }, make("h2", {}, title), ...children);
}
